"""Load factors of ISO 6336-1: those that remain, and those that are 1 because the contact is solved."""

from __future__ import annotations

from semiwear.scene.rating_fields import RatingTable


def load_factors(table: RatingTable) -> dict[str, str]:
    """Load factors of a table by their symbols, each with its value and the reason for it."""
    application, dynamic = table.application_factor, table.dynamic_factor
    external = "the torques are those that the teeth bear" if application == 1.0 else "given"
    internal = "the contact is quasi-static, without internal dynamics: give it where it matters"
    return {
        "K_A": f"{application:g}: {external}",
        "K_v": f"{dynamic:g}: {internal if dynamic == 1.0 else 'given'}",
        "K_Hbeta, K_Fbeta": "1: the load along the face is solved on the worn flanks, with misalignment",
        "K_Halpha, K_Falpha": "1: the load sharing between tooth pairs is solved, with pitch errors",
    }

"""Load factors of ISO 6336-1 that a solved contact makes unnecessary, and those that it does not."""

from __future__ import annotations

from semiwear.scene.rating_fields import RatingTable


def load_factors(table: RatingTable) -> dict[str, str]:
    """Load factors of a table by their symbols, each with its value and why it has that value."""
    application, dynamic = table.application_factor, table.dynamic_factor
    outside = "the torques are what the teeth bear" if application == 1.0 else "given"
    inner = "the contact is quasi-static and knows no inner dynamics: give it where it matters"
    return {
        "K_A": f"{application:g}: {outside}",
        "K_v": f"{dynamic:g}: {inner if dynamic == 1.0 else 'given'}",
        "K_Hbeta, K_Fbeta": "1: loads along the face are solved on the worn flanks, misalignment and all",
        "K_Halpha, K_Falpha": "1: loads are shared between tooth pairs by solving the contact, pitch errors and all",
    }

"""Both bodies of a pair, and what a scene gives for each of them."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BODIES", "BodyCoefficients"]

BODIES = ("pinion", "gear")
"""Both bodies, in the order in which a scene keeps them."""


@dataclass(frozen=True, kw_only=True)
class BodyCoefficients:
    """Wear coefficients of bodies that wear differently; None for a body that does not wear.

    Attributes
    ----------
    pinion, gear : float or None
        Wear coefficient [mm2/N].
    """

    pinion: float | None = None
    gear: float | None = None

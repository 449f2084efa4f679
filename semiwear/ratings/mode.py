"""A failure mode, and the safeties that it gives of worn flanks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.ratings.contact import RatedContact, RatedFlanks, WornStep

_BESIDE = 0.01  # of a required safety


@dataclass(frozen=True, eq=False)
class Rated:
    """Safeties of one failure mode over the wear steps.

    Attributes
    ----------
    safety : (wear_step, body) array
        Least of the flank; NaN where nothing is rated.
    height, face : (wear_step, body) arrays [mm]
        Where it is found: height above the pitch surface, and station along the face.
    flank : (body, face, node) array
        Safety of every point of the last wear step's flanks; NaN where none is rated.
    damage : (wear_step, body) array or None
        Miner's sum at the required safety, greatest of the flank; None of a mode that remembers no load cycles.
    meshes : (body,) array or None
        Engagements of one gear tooth until that sum is 1, NaN where the run ends before; None likewise.
    exponent : (body,) array or None
        Relative change of these engagements over that of the required safety; None likewise.
    """

    safety: FloatArray
    height: FloatArray
    face: FloatArray
    flank: FloatArray
    damage: FloatArray | None = None
    meshes: FloatArray | None = None
    exponent: FloatArray | None = None


def life_exponent(life: Callable[[float], FloatArray], required: float) -> FloatArray:
    """Relative change of lives over that of the required safety; NaN where there is no life.

    Parameters
    ----------
    life : callable
        From a required safety to lives, (body,).
    required : float
    """
    # with less required a run may end before
    longer, own, shorter = life(required * (1.0 - _BESIDE)), life(required), life(required * (1.0 + _BESIDE))
    known = np.isfinite(longer)
    change = shorter - np.where(known, longer, own)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = change / (own * _BESIDE * (1.0 + known))
    return np.where(own > 0.0, found, np.nan)


class FailureMode(Protocol):
    """A failure mode with the data that a scene's table gives."""

    @property
    def required_safety(self) -> float:
        """Safety below which the pair counts as failed."""

    @property
    def factors(self) -> Mapping[str, str]:
        """Factors of the rating by their symbols, each with its value and why it has that value."""

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step, of which the first is unworn."""


def rated_locally(steps: Sequence[WornStep], safety_of: Callable[[RatedContact], FloatArray]) -> Rated:
    """Safeties of a mode that knows no load cycles: each wear step by itself, the worst load of the spectrum.

    Parameters
    ----------
    steps : sequence of WornStep
    safety_of : callable
        Safety in the contact lines, an array that broadcasts to (body, roll, face). What it says of slices that are
        not `RatedContact.rated` is not looked at.
    """

    def worst(step: WornStep) -> FloatArray:
        return np.asarray(np.fmin.reduce([c.on_flanks(safety_of(c), worst=np.fmin) for c in step.contacts]))

    return rated_by_flank(steps[-1].flanks, [worst(step) for step in steps])


def rated_by_flank(flanks: RatedFlanks, safeties: Sequence[FloatArray]) -> Rated:
    """Least safeties and their places from those of all nodes at every wear step, (body, face, node) each."""
    bodies = flanks.profile.shape[0]
    by_node = np.stack(safeties).reshape(len(safeties), bodies, -1)
    blank = np.isnan(by_node)
    least = np.where(blank, np.inf, by_node).argmin(axis=2)[..., None]
    body = np.arange(bodies)
    missing = blank.all(axis=2)
    face = np.broadcast_to(flanks.face[:, None], flanks.profile.shape[1:]).ravel()

    def told(values: FloatArray) -> FloatArray:
        return np.where(missing, np.nan, values)

    return Rated(
        safety=told(np.take_along_axis(by_node, least, axis=2)[..., 0]),
        height=told(flanks.height.reshape(bodies, -1)[body, least[..., 0]]),
        face=told(face[least[..., 0]]),
        flank=np.asarray(safeties[-1]),
    )

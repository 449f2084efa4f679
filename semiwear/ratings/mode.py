"""Failure modes and their safeties."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.ratings.contact import RatedContact, RatedFlanks, WornStep

_DIFFERENCE = 0.01  # of the required safety, for its derivative


@dataclass(frozen=True, eq=False)
class Rated:
    """Safeties of one failure mode over the wear steps.

    Attributes
    ----------
    safety : (wear_step, body) array
        Least safety of the flank; NaN where nothing is rated.
    height, face : (wear_step, body) arrays [mm]
        Place of the least safety: height above the pitch surface, and station along the face.
    flank : (body, face, node) array
        Safety of every point at the last wear step; NaN where the point is not rated.
    damage : (wear_step, body) array or None
        Greatest Miner's sum of the flank at the required safety; None for modes without cumulative damage.
    meshes : (body,) array or None
        Engagements of one gear tooth until that sum is 1, NaN where the run ends before; None as above.
    exponent : (body,) array or None
        Relative change of these engagements over that of the required safety; None as above.
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
    longer, shorter = life(required * (1.0 - _DIFFERENCE)), life(required * (1.0 + _DIFFERENCE))
    lives = life(required)
    known = np.isfinite(longer)  # the run may end before the longer life
    change = shorter - np.where(known, longer, lives)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = change / (lives * _DIFFERENCE * (1.0 + known))
    return np.where(lives > 0.0, found, np.nan)


class FailureMode(Protocol):
    """A failure mode with the data that a scene's table gives."""

    @property
    def required_safety(self) -> float:
        """Safety below which the pair counts as failed."""

    @property
    def factors(self) -> Mapping[str, str]:
        """Factors of the rating by their symbols, each with its value and the reason for it."""

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step; the first is the unworn state."""


def rated_locally(steps: Sequence[WornStep], safety_of: Callable[[RatedContact], FloatArray]) -> Rated:
    """Safeties of a mode without cumulative damage: of each wear step, under the worst load of the spectrum.

    Parameters
    ----------
    steps : sequence of WornStep
    safety_of : callable
        Safety in the contact lines, an array that broadcasts to (body, roll, face). Slices that are not
        `RatedContact.rated` are ignored.
    """

    def worst(step: WornStep) -> FloatArray:
        return np.asarray(np.fmin.reduce([c.on_flanks(safety_of(c), worst=np.fmin) for c in step.contacts]))

    return rated_by_flank(steps[-1].flanks, [worst(step) for step in steps])


def rated_by_flank(flanks: RatedFlanks, safeties: Sequence[FloatArray]) -> Rated:
    """Least safeties and their places from safeties at all nodes, one (body, face, node) array for each wear step."""
    by_node = np.stack(safeties).reshape(len(safeties), flanks.profile.shape[0], -1)
    blank = np.isnan(by_node)
    least = np.where(blank, np.inf, by_node).argmin(axis=2)
    height, face = places_of(flanks, np.where(blank.all(axis=2), -1, least))
    return Rated(np.fmin.reduce(by_node, axis=2), height, face, np.asarray(safeties[-1]))


def places_of(flanks: RatedFlanks, nodes: IntArray) -> tuple[FloatArray, FloatArray]:
    """Heights and face coordinates of nodes (wear_step, body), numbered along face and profile; NaN for -1 [mm]."""
    height = flanks.height.reshape(nodes.shape[1], -1)[np.arange(nodes.shape[1]), nodes]
    face = np.broadcast_to(flanks.face[:, None], flanks.profile.shape[1:]).ravel()[nodes]
    return np.where(nodes < 0, np.nan, height), np.where(nodes < 0, np.nan, face)

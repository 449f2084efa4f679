"""Modifications of a flank: material removed along its normal.

Each part is a function of the profile coordinate p (from root to tip) and the face coordinate f (from the lower to
the upper end), with u = (p - root)/(tip - root) and v = (f - lower)/(upper - lower):

    tip relief     amount t^e,  t = (p - tip)/length + 1 where positive; e = 2 parabolic, 1 linear
    root relief    the same from the root end
    crowning       amount (2 v - 1)^2
    lead slope     amount v when positive, |amount| (1 - v) when negative
    bias           |amount|/2 + amount/2 (2 u - 1)(2 v - 1)
    deviations     a grid: the highest material less the local material

None is negative on the flank. Beyond its ends the reliefs and the crowning continue unchanged; lead slope, bias and
deviations keep the value of the end. Pressure depends on the slope of a gap: a linear relief has a kink at its start
and a peak of pressure there, a parabolic one has none.

Source: terms as in ISO 21771:2007, section 7 (tip and root relief, crowning, helix slope and bias modification).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray

_POWER = {"linear": 1, "parabolic": 2}
_PART_OF_PROFILE = 1.0 / 3.0  # of the profile's length: default length of a relief


class Deviations(Protocol):
    """A grid of deviations of a flank, such as `DeviationGrid`."""

    @property
    def span(self) -> float:
        """Highest less lowest material [mm]."""

    def removed(
        self, from_root: FloatArray, profile_length: FloatArray, from_lower: FloatArray, face_length: float
    ) -> FloatArray:
        """Material removed [mm] at distances from the root end and the lower end of the flank [mm]."""


@dataclass(frozen=True)
class Relief:
    """Relief at one end of the profile.

    Attributes
    ----------
    amount : float [mm]
        Depth removed at the end itself.
    length : float [mm] or None
        From the end to where the relief begins; None: a third of the profile.
    form : str
        ``"parabolic"`` or ``"linear"``.

    Raises
    ------
    ValueError
        For a negative amount, a length that is not positive or another form.
    """

    amount: float = 0.0
    length: float | None = None
    form: Literal["parabolic", "linear"] = "parabolic"

    def __post_init__(self) -> None:
        if not (isfinite(self.amount) and self.amount >= 0.0):
            raise ValueError(f"amount of a relief: a finite number >= 0 [mm], not {self.amount!r}")
        if self.length is not None and not (isfinite(self.length) and self.length > 0.0):
            raise ValueError(f"length of a relief: a finite number > 0 [mm], not {self.length!r}")
        if self.form not in _POWER:
            raise ValueError(f"form of a relief: one of {', '.join(_POWER)}, not {self.form!r}")

    def depth(self, from_end: FloatArray, profile_length: FloatArray) -> FloatArray:
        """Material removed at distances from the end into the flank, for profiles of some length [mm]."""
        length = _PART_OF_PROFILE * profile_length if self.length is None else self.length
        return self.amount * np.maximum(1.0 - from_end / length, 0.0) ** _POWER[self.form]


@dataclass(frozen=True)
class FlankModification:
    """Material removed from one body's flank along its normal.

    Attributes
    ----------
    tip_relief, root_relief : Relief
    crowning : float [mm]
        Depth removed at both ends of the face; zero in the middle.
    lead_slope : float [mm]
        Depth removed at the upper end of the face if positive, at the lower end if negative.
    bias : float [mm]
        Twist: the whole difference between the corners. Positive takes most at tip and upper end, and at root and
        lower end.
    deviations : Deviations, optional
        A grid of deviations.

    Raises
    ------
    ValueError
        For a negative crowning or numbers that are not finite.
    """

    tip_relief: Relief = Relief()
    root_relief: Relief = Relief()
    crowning: float = 0.0
    lead_slope: float = 0.0
    bias: float = 0.0
    deviations: Deviations | None = None

    def __post_init__(self) -> None:
        if not (isfinite(self.crowning) and self.crowning >= 0.0):
            raise ValueError(f"crowning: a finite number >= 0 [mm], not {self.crowning!r}")
        for name in ("lead_slope", "bias"):
            if not isfinite(getattr(self, name)):
                raise ValueError(f"{name}: a finite number [mm], not {getattr(self, name)!r}")

    @property
    def tallest(self) -> float:
        """Bound on the difference in depth between two places of the flank [mm]."""
        parts = (self.tip_relief.amount, self.root_relief.amount, self.crowning, self.lead_slope, self.bias)
        return sum(map(abs, parts)) + (0.0 if self.deviations is None else self.deviations.span)

    def depth(
        self, profile: ArrayLike, face: ArrayLike, root: ArrayLike, tip: ArrayLike, ends: tuple[float, float]
    ) -> FloatArray:
        """Material removed at flank points [mm].

        Parameters
        ----------
        profile, face : arrays that broadcast [mm]
            Profile and face coordinates of the points.
        root, tip : floats or arrays that broadcast with them [mm]
            Profile coordinates of the flank's ends where the points lie.
        ends : (float, float) [mm]
            Face coordinates of the lower and the upper end.

        Returns
        -------
        array [mm]
            Of the broadcast shape; >= 0.
        """
        p, f, low, high = np.broadcast_arrays(*(np.asarray(entry, float) for entry in (profile, face, root, tip)))
        profile_length, face_length = high - low, ends[1] - ends[0]
        across, along = (p - low) / profile_length, (f - ends[0]) / face_length
        u, v = np.clip(across, 0.0, 1.0), np.clip(along, 0.0, 1.0)
        total = (
            self.tip_relief.depth(high - p, profile_length)
            + self.root_relief.depth(p - low, profile_length)
            + self.crowning * (2.0 * along - 1.0) ** 2
            + abs(self.lead_slope) * (v if self.lead_slope >= 0.0 else 1.0 - v)
            + 0.5 * (abs(self.bias) + self.bias * (2.0 * u - 1.0) * (2.0 * v - 1.0))
        )
        if self.deviations is not None:
            total = total + self.deviations.removed(p - low, profile_length, f - ends[0], face_length)
        return np.asarray(total, dtype=float)

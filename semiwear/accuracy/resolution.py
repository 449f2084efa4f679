"""Resolution for a requested accuracy, from the contribution of each parameter to the error and to the cost.

A discretisation with n elements has an error e = c n^-q. Two results that differ in n alone give c (Richardson 1911,
Phil. Trans. R. Soc. A 210, 307-357); contributions of several parameters add up as squares. The orders q are those of
runs on worn flanks, where edges and the border of contact limit most of them to one. In the number of roll positions
wear depths, load shares and transmission errors converge with at least the order 1.5: in the shipped scene and four
random ones the greatest error of a depth is 2.1 to 3.8 times smaller at 24 than at 12 positions, and 5 to 12 times
smaller at 48. Pressures are of first order.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from semiwear.results.kinds import Errors, kind_of
from semiwear.scene.tables import Numerics

_REFINED = 1.2  # factor of one refinement
_OF_WEAR = frozenset({"wear_depth", "load_share_max", "transmission_error"})  # kinds of quantities


@dataclass(frozen=True)
class Parameter:
    """A parameter of the discretisation in `[numerics]`.

    Attributes
    ----------
    name : str
    start : int
        Value in the coarse run.
    most : int
        Greatest value; beyond it rounding and the narrowness of slices outweigh the gain.
    order : float
        Order q of the error.
    cost : float
        Exponent of the computing time.
    refined : bool
        Whether the error is estimated with a finer value; otherwise, where that is expensive and the order high, with
        a coarser one.
    of_wear : float, optional
        Order of wear depths, load shares and transmission errors, if different.
    """

    name: str
    start: int
    most: int
    order: float
    cost: float
    refined: bool = True
    of_wear: float | None = None

    def order_of(self, quantity: str) -> float:
        """The order q of a reported quantity."""
        return self.order if self.of_wear is None or kind_of(quantity) not in _OF_WEAR else self.of_wear


PARAMETERS = (
    Parameter("roll_positions", 12, 144, 1.0, 1.0, of_wear=1.5),
    Parameter("face_slices", 31, 151, 1.0, 1.6),
    Parameter("profile_points", 81, 401, 1.5, 0.3),
    Parameter("harmonics", 17, 65, 2.0, 0.5, refined=False),
    Parameter("cells_per_half_width", 4, 16, 1.0, 1.5),
)


@dataclass(frozen=True)
class Contribution:
    """Contribution of one parameter to the errors.

    Attributes
    ----------
    parameter : Parameter
    value : int
        Value of the parameter to which the errors belong.
    errors : dict of str to float
        Relative errors by quantity.
    open : bool
        Whether the value may be changed.
    """

    parameter: Parameter
    value: int
    errors: Errors
    open: bool

    @classmethod
    def between(cls, parameter: Parameter, value: int, other: int, change: Errors, open_: bool) -> Contribution:
        """Richardson's estimate from the change between `value` and `other`, with the lower order."""
        ratio = (other / value) ** parameter.order
        share = ratio / (ratio - 1.0) if other > value else ratio / (1.0 - ratio)
        return cls(parameter, value, {name: share * size for name, size in change.items()}, open_)

    def at(self, value: int) -> Errors:
        """Errors at another value."""
        coarser = self.value / value
        return {name: coarser ** self.parameter.order_of(name) * size for name, size in self.errors.items()}


def parameters_of(numerics: Numerics) -> tuple[Parameter, ...]:
    """The parameters that affect a result."""
    idle = set()
    if numerics.fidelity != "patch":
        idle.add("cells_per_half_width")
    if numerics.tooth_compliance != "prism":
        idle.add("harmonics")
    return tuple(parameter for parameter in PARAMETERS if parameter.name not in idle)


def together(errors: Iterable[Errors]) -> Errors:
    """Root of the sum of squares by quantity, for contributions of independent signs."""
    squares: Errors = {}
    for contribution in errors:
        for name, size in contribution.items():
            squares[name] = squares.get(name, 0.0) + size**2
    return {name: math.sqrt(size) for name, size in squares.items()}


def contributions_at(parts: tuple[Contribution, ...], values: Mapping[str, int]) -> dict[str, Errors]:
    """Errors by parameter at given values."""
    return {part.parameter.name: part.at(values[part.parameter.name]) for part in parts}


def chosen_resolution(
    parts: tuple[Contribution, ...], factors: Mapping[str, float], allowed: float
) -> dict[str, int]:
    """The cheapest values whose total error is within the allowed one, by a greedy search.

    In each step the parameter is refined that reduces the error of the worst quantity most per added time.

    Parameters
    ----------
    parts : tuple of Contribution
    factors : mapping
        Correction factors on the errors of quantities; 1 for those that are missing.
    allowed : float

    Returns
    -------
    dict of str to int
        The best values within the limits of the parameters where these do not suffice.
    """
    values = {part.parameter.name: part.value for part in parts}
    while True:
        errors = contributions_at(parts, values)
        total = {name: factors.get(name, 1.0) * size for name, size in together(errors.values()).items()}
        if not total or max(total.values()) <= allowed:
            return values
        quantity = max(total, key=lambda name: (total[name], name))
        free = [part.parameter for part in parts if part.open and values[part.parameter.name] < part.parameter.most]
        gains = [errors[p.name].get(quantity, 0.0) ** 2 * p.order_of(quantity) / p.cost for p in free]
        greatest = max(gains, default=0.0)
        if greatest <= 0.0:
            return values
        chosen = free[gains.index(greatest)]
        value = values[chosen.name]
        values[chosen.name] = min(max(round(_REFINED * value), value + 1), chosen.most)

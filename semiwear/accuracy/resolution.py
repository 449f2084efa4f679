"""Resolution for an accuracy: what each number of cells, positions and terms contributes to the error, and costs.

Every parameter n of a discretisation leaves an error e = c n^-q. Two results that differ in n alone tell c
(Richardson 1911, Phil. Trans. R. Soc. A 210, 307-357); contributions of several parameters add up as squares. The
orders are those that runs on worn flanks show: edges and the border of contact keep most of them to the first. In
the roll positions wear depths, load shares and transmission errors gain more, at least the order 1.5: on the shipped
scene and four drawn ones the worst depth errs by 2.1 to 3.8 times less at 24 than at 12 positions, and by 5 to 12
times less at 48. Pressures follow the first order.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from semiwear.results.kinds import Errors, kind_of
from semiwear.scene.tables import Numerics

__all__ = [
    "PARAMETERS",
    "Contribution",
    "Parameter",
    "chosen_resolution",
    "contributions_at",
    "parameters_of",
    "together",
]

_REFINED = 1.2  # in one go
_OF_WEAR = frozenset({"wear_depth", "load_share_max", "transmission_error"})  # kinds


@dataclass(frozen=True)
class Parameter:
    """A number of `[numerics]` that resolves something.

    Attributes
    ----------
    name : str
    start : int
        Of a coarse run.
    most : int
        Beyond, rounding and the narrowness of slices spoil what is gained.
    order : float
        q.
    cost : float
        Exponent with which the time of a run grows.
    refined : bool
        Whether a finer value tells the error, or a coarser one: where a finer one is dear and the order is high.
    of_wear : float, optional
        q of wear depths, load shares and transmission errors, where it is another.
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
    """Share of one parameter in the errors.

    Attributes
    ----------
    parameter : Parameter
    value : int
        At which the errors hold.
    errors : dict of str to float
        Relative, by quantity.
    open : bool
        Whether the value may be changed.
    """

    parameter: Parameter
    value: int
    errors: Errors
    open: bool

    @classmethod
    def between(cls, parameter: Parameter, value: int, other: int, change: Errors, open_: bool) -> Contribution:
        """From the change that `other` in place of `value` makes: Richardson's estimate, of the lower order."""
        ratio = (other / value) ** parameter.order
        share = ratio / (ratio - 1.0) if other > value else ratio / (1.0 - ratio)
        return cls(parameter, value, {name: share * size for name, size in change.items()}, open_)

    def at(self, value: int) -> Errors:
        """Errors at another value."""
        coarser = self.value / value
        return {name: coarser ** self.parameter.order_of(name) * size for name, size in self.errors.items()}


def parameters_of(numerics: Numerics) -> tuple[Parameter, ...]:
    """The parameters that play a part."""
    idle = set()
    if numerics.fidelity != "patch":
        idle.add("cells_per_half_width")
    if numerics.tooth_compliance != "prism":
        idle.add("harmonics")
    return tuple(parameter for parameter in PARAMETERS if parameter.name not in idle)


def together(errors: Iterable[Errors]) -> Errors:
    """Root of the sum of squares, by quantity: contributions of independent sources have independent signs."""
    squares: Errors = {}
    for each in errors:
        for name, size in each.items():
            squares[name] = squares.get(name, 0.0) + size**2
    return {name: math.sqrt(size) for name, size in squares.items()}


def contributions_at(parts: tuple[Contribution, ...], values: Mapping[str, int]) -> dict[str, Errors]:
    """Errors of every parameter at some values."""
    return {part.parameter.name: part.at(values[part.parameter.name]) for part in parts}


def chosen_resolution(
    parts: tuple[Contribution, ...], factors: Mapping[str, float], allowed: float
) -> dict[str, int]:
    """The cheapest values, found step by step, whose errors add up to no more than what is allowed.

    In each step the parameter is refined that lowers the worst quantity's error most for the time that it adds.

    Parameters
    ----------
    parts : tuple of Contribution
    factors : mapping
        On the errors of each quantity, from experience; 1 where none is named.
    allowed : float

    Returns
    -------
    dict of str to int
        As good as the limits of the parameters permit where that is not enough.
    """
    values = {part.parameter.name: part.value for part in parts}
    while True:
        errors = contributions_at(parts, values)
        total = {name: factors.get(name, 1.0) * size for name, size in together(errors.values()).items()}
        if not total or max(total.values()) <= allowed:
            return values
        free = [part for part in parts if part.open and values[part.parameter.name] < part.parameter.most]
        quantity = max(total, key=lambda name: (total[name], name))
        gains = {
            part.parameter.name: errors[part.parameter.name].get(quantity, 0.0) ** 2
            * part.parameter.order_of(quantity)
            / part.parameter.cost
            for part in free
        }
        if not gains or max(gains.values()) <= 0.0:
            return values
        name = max(gains, key=lambda key: gains[key])
        most = next(part.parameter.most for part in free if part.parameter.name == name)
        values[name] = min(max(round(_REFINED * values[name]), values[name] + 1), most)

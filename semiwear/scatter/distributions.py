"""Distributions of a field: quantile functions, from uniform numbers to values.

Normal and log-normal distributions may be truncated below and above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from math import inf, log
from sys import float_info
from typing import Protocol, cast

import numpy as np
from scipy.special import ndtr, ndtri

from semiwear.arrays import FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.measured.life_spread import log_deviation
from semiwear.scene import Scene
from semiwear.scene.closest import advised_name
from semiwear.scene.values import shown
from semiwear.untyped import Table

_COEFFICIENT = "wear.coefficient_mm2_per_N"

USUAL_VARIATION = 0.5
"""Coefficient of variation of the wear coefficient from part to part if it is unknown: tests of equal parts
differ by tens of per cent (Blau 2017, Wear 376-377, 1830-1840). An assumption of that order, not measured."""


class Distribution(Protocol):
    """Distribution of a number."""

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which the number lies with a probability between 0 and 1."""

    def problems(self, field: str) -> list[Problem]:
        """Problems of the parameters."""


@dataclass(frozen=True)
class Normal:
    """Normal distribution, possibly truncated.

    Attributes
    ----------
    mean, deviation : float
        Before it is truncated, in the field's unit.
    low, high : float
        Limits, in the field's unit. Default: none.
    """

    mean: float
    deviation: float
    low: float = -inf
    high: float = inf

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which the number lies with a probability between 0 and 1, of the same shape."""
        return _cut(share, self.mean, self.deviation, self.low, self.high)

    def problems(self, field: str) -> list[Problem]:
        """Problems of the parameters."""
        return [*_needs_positive(field, "deviation", self.deviation), *_needs_order(field, self.low, self.high)]


@dataclass(frozen=True)
class LogNormal:
    """Log-normal distribution, possibly truncated.

    The logarithm is normally distributed, with the deviation sqrt(ln(1 + variation^2)).

    Attributes
    ----------
    median : float
        Before it is truncated, in the field's unit.
    variation : float
        Coefficient of variation before it is truncated: standard deviation over mean.
    low, high : float
        Limits, in the field's unit. Default: none.
    """

    median: float
    variation: float
    low: float = 0.0
    high: float = inf

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which the number lies with a probability between 0 and 1, of the same shape."""
        low = log(self.low) if self.low > 0.0 else -inf
        high = log(self.high) if self.high < inf else inf
        return np.asarray(np.exp(_cut(share, log(self.median), log_deviation(self.variation), low, high)))

    def problems(self, field: str) -> list[Problem]:
        """Problems of the parameters."""
        return [
            *_needs_positive(field, "median", self.median),
            *_needs_positive(field, "variation", self.variation),
            *_needs_order(field, max(self.low, 0.0), self.high),
        ]


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between two values.

    Attributes
    ----------
    low, high : float
        In the field's unit.
    """

    low: float
    high: float

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which the number lies with a probability between 0 and 1, of the same shape."""
        return np.asarray(self.low + (self.high - self.low) * share)

    def problems(self, field: str) -> list[Problem]:
        """Problems of the parameters."""
        return _needs_order(field, self.low, self.high)


@dataclass(frozen=True)
class Triangular:
    """Triangular distribution: density linear up to the mode and down again.

    Attributes
    ----------
    low, mode, high : float
        Least, most likely and greatest value, in the field's unit.
    """

    low: float
    mode: float
    high: float

    def quantile(self, share: FloatArray) -> FloatArray:
        """Values below which the number lies with a probability between 0 and 1, of the same shape."""
        width, rise = self.high - self.low, self.mode - self.low
        below = share * width <= rise
        up = self.low + np.sqrt(share * width * rise)
        down = self.high - np.sqrt((1.0 - share) * width * (self.high - self.mode))
        return np.where(below, up, down)

    def problems(self, field: str) -> list[Problem]:
        """Problems of the parameters."""
        found = _needs_order(field, self.low, self.high)
        if not found and not self.low <= self.mode <= self.high:
            allowed = f"{self.low:g} to {self.high:g}"
            found.append(Problem(f"{field}, mode", self.mode, allowed, "the most likely value, between low and high"))
        return found


DISTRIBUTIONS: Mapping[str, type[Normal | LogNormal | Uniform | Triangular]] = {
    "normal": Normal,
    "lognormal": LogNormal,
    "uniform": Uniform,
    "triangular": Triangular,
}
"""Distributions by their names in a study file."""


def usual_wear_coefficient(scene: Scene) -> LogNormal:
    """Assumed scatter of the wear coefficient about that of a scene: log-normal, coefficient of variation 0.5.

    Tests of equal parts differ by tens of per cent (Blau 2017, Wear 376-377, 1830-1840); 0.5 is an assumption of that
    order, not measured.

    Raises
    ------
    SceneError
        The scene does not wear, or gives a coefficient for each body.

    Examples
    --------
    >>> import semiwear as sw
    >>> sw.usual_wear_coefficient(sw.load_scene("spur_fzg_c"))
    LogNormal(median=1e-13, variation=0.5, low=0.0, high=inf)
    """
    found = None if scene.wear is None else scene.wear.coefficient_mm2_per_N
    if not isinstance(found, float | int):
        raise SceneError.of(_COEFFICIENT, shown(found), "one number for both bodies", "give the distribution in full")
    return LogNormal(float(found), USUAL_VARIATION)


def median_is_the_scenes(field: str, raw: object) -> bool:
    """Whether a distribution of a study file has the wear coefficient of the scene as its median."""
    named = isinstance(raw, Mapping) and raw.get("distribution") == "lognormal"
    return named and field == _COEFFICIENT and "median" not in cast(Table, raw)


def read_distribution(field: str, raw: object, scene: Scene | None, problems: list[Problem]) -> Distribution | None:
    """A distribution from a table of a study file, or the given one; None, and problems, if it is none.

    Without a scene, a median that is the scene's is 1.
    """
    its_median = median_is_the_scenes(field, raw)
    if isinstance(raw, Mapping):
        raw = _from_table(field, raw, scene, problems)
        if raw is None:
            return None
    if not isinstance(raw, Normal | LogNormal | Uniform | Triangular):
        allowed = "Normal, LogNormal, Uniform or Triangular"
        problems.append(Problem(field, shown(raw), allowed, "give e.g. Normal(mean=1600, deviation=80)"))
        return None
    wrong = _not_numbers(field, raw) or raw.problems(field)
    if not wrong and not (scene is None and its_median):
        wrong = _nothing_left(field, raw)
    problems += wrong
    return None if wrong else raw


def _from_table(field: str, table: Mapping[str, object], scene: Scene | None, problems: list[Problem]) -> object:
    name = table.get("distribution")
    kind = DISTRIBUTIONS.get(name) if isinstance(name, str) else None
    allowed = " or ".join(f'"{known}"' for known in DISTRIBUTIONS)
    if kind is None:
        example = 'give e.g. {distribution = "normal", mean = 1600, deviation = 80}'
        fix = advised_name(str(name), DISTRIBUTIONS, example, quoted=True)
        problems.append(Problem(f"{field}, distribution", shown(name), allowed, fix))
        return None
    given = {key: value for key, value in table.items() if key != "distribution"}
    if median_is_the_scenes(field, table):
        try:
            usual = LogNormal(1.0, USUAL_VARIATION) if scene is None else usual_wear_coefficient(scene)
            given = {"median": usual.median, "variation": usual.variation} | given
        except SceneError as error:
            problems += error.problems
            return None
    names = [parameter.name for parameter in fields(kind)]
    needed = [parameter.name for parameter in fields(kind) if parameter.default is MISSING]
    wrong = [
        Problem(f"{field}, {key}", shown(given[key]), f"{', '.join(names)}", advised_name(key, names, "remove it"))
        for key in given
        if key not in names
    ]
    wrong += [Problem(f"{field}, {key}", None, "a number", f"needed by {name}") for key in needed if key not in given]
    problems += wrong
    return None if wrong else kind(**given)  # type: ignore[arg-type]


def _not_numbers(field: str, raw: Normal | LogNormal | Uniform | Triangular) -> list[Problem]:
    found = []
    for entry in fields(raw):
        value = getattr(raw, entry.name)
        plain = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not plain or not (value == entry.default or abs(value) <= float_info.max):  # integers may be greater
            found.append(Problem(f"{field}, {entry.name}", shown(value), "a finite number", "give a number"))
    return found


def _needs_positive(field: str, name: str, value: float) -> list[Problem]:
    if value > 0.0:
        return []
    return [Problem(f"{field}, {name}", value, "greater than 0", "for a fixed value, change the scene")]


def _needs_order(field: str, low: float, high: float) -> list[Problem]:
    if low < high:
        return []
    return [Problem(f"{field}, high", high, f"greater than low = {low:g}", "exchange them?")]


def _nothing_left(field: str, raw: Distribution) -> list[Problem]:
    if not isinstance(raw, Normal | LogNormal) or np.isfinite(raw.quantile(np.array(0.5))):
        return []
    limits = f"{raw.low:g} to {raw.high:g}"
    allowed = "limits with some of the distribution between them"
    return [Problem(f"{field}, low and high", limits, allowed, "nothing is left so far out: check their unit")]


def _cut(share: FloatArray, mean: float, deviation: float, low: float, high: float) -> FloatArray:
    """Quantiles of a truncated normal distribution, from the side where its tail is not lost by rounding."""
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if a > 0.0:  # far above the mean the distribution function is 1 to all digits
        upper = ndtr(-a) + share * (ndtr(-b) - ndtr(-a))
        return np.asarray(mean - deviation * ndtri(upper))
    below = ndtr(a) + share * (ndtr(b) - ndtr(a))
    return np.asarray(mean + deviation * ndtri(below))

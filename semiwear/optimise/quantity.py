"""Quantities by which a design is judged: a variable of a result, its body and wear state, and limits on it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from semiwear.errors import Problem
from semiwear.meshing.flank_pair import BODIES
from semiwear.optimise.space import scene_value
from semiwear.results import VARIABLES, Variable
from semiwear.scene import Scene
from semiwear.scene.closest import advised_name
from semiwear.scene.schema import SCHEMAS
from semiwear.scene.values import meant_number, shown
from semiwear.sweep.measure import Measure, Measured

_GROUPS = ("history", "life")
_TIMES = ("end", "unworn", "worst")
_STEPS = "wear_step"
_STATES = {"unworn": 0, "end": -1}
WITH_PEAKS = "/history/transmission_error_amplitude"
"""The quantity that may be found with its peaks between roll positions."""

_TEXT = re.compile(r"\s*(?P<name>\w+)\s*(\[(?P<which>[\w\s,]*)\])?\s*")
_LIMIT = re.compile(
    r"\s*(?P<sign><=|>=)\s*(?P<value>[-+]?([0-9]+[.]?[0-9]*|[.][0-9]+)(e[-+]?[0-9]+)?)\s*", re.IGNORECASE
)


@dataclass(frozen=True)
class Quantity:
    """A number from a result.

    Attributes
    ----------
    text : str
        As given, e.g. ``"root_stress_max[pinion, worst]"``.
    variable : Variable
        A variable of `/history` or `/life`.
    body : str
        Empty: the worse of both bodies.
    time : str
        ``"end"``: at the end of the run; ``"unworn"``; or ``"worst"``: the worst of all wear states.
    """

    text: str
    variable: Variable
    body: str = ""
    time: str = "end"

    @property
    def path(self) -> str:
        """Path in a result."""
        return f"/{self.variable.group}/{self.variable.name}"

    @property
    def units(self) -> str:
        """Unit of the number."""
        return self.variable.units

    def value(self, measured: Measured, *, low_is_good: bool) -> float:
        """Number of a solved scene; NaN if its result has none, infinite for a life without end.

        Parameters
        ----------
        measured : Measured
        low_is_good : bool
            Whether the greatest of several values is the worst, else the least.
        """
        if self.path not in measured.variables:
            return float("nan")
        values, dims = np.asarray(measured.variables[self.path], float), list(self.variable.dims)
        if values.ndim < len(dims):  # only the last wear state was read off
            dims.remove(_STEPS)
        if "body" in dims and self.body:
            labels = [str(label) for label in measured.coords["body"]]
            if self.body not in labels:
                return float("nan")
            values = values.take(labels.index(self.body), axis=dims.index("body"))
            dims.remove("body")
        if _STEPS in dims and self.time != "worst":
            values = values.take(0 if self.time == "unworn" else -1, axis=dims.index(_STEPS))
        known = values[~np.isnan(values)]
        if not known.size:
            return float("nan")
        return float(known.max() if low_is_good else known.min())


@dataclass(frozen=True)
class Limit:
    """A limit that a design has to keep.

    Attributes
    ----------
    quantity : Quantity
    bound : float
        In the unit of the quantity.
    at_most : bool
        Whether it is an upper limit.
    """

    quantity: Quantity
    bound: float
    at_most: bool

    @property
    def condition(self) -> str:
        """Sign and bound, e.g. ``"<= 2.5"``."""
        return f"{'<=' if self.at_most else '>='} {self.bound:g}"

    def __str__(self) -> str:
        units = "" if self.quantity.units == "1" else f" {self.quantity.units}"
        return f"{self.quantity.text} {self.condition}{units}"


def quantity_of(field: str, text: object, problems: list[Problem]) -> Quantity | None:
    """Quantity from text; None, with a problem added, if no result has it."""
    known = {name: entry for (group, name), entry in VARIABLES.items() if group in _GROUPS and entry.dtype != "str"}
    match = _TEXT.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        fix = 'such as "wear_depth_max", "root_stress_max[pinion]" or "transmission_error_amplitude[worst]"'
        problems.append(Problem(field, shown(text), "the name of a variable of /history or /life", fix))
        return None
    name = match["name"]
    words = [word for word in re.split(r"[\s,]+", match["which"] or "") if word]
    if name not in known:
        fix = advised_name(name, known, "see the group /history of a result")
        problems.append(Problem(field, shown(name), "a variable of /history or /life", fix))
        return None
    entry = known[name]
    unknown = [word for word in words if word not in (*_TIMES, *BODIES)]
    bodies, times = [word for word in words if word in BODIES], [word for word in words if word in _TIMES]
    if unknown or len(bodies) > 1 or len(times) > 1:
        allowed = f"one of {', '.join(_TIMES)} and one of {', '.join(BODIES)} in the brackets"
        problems.append(Problem(field, shown(text), allowed, f"write {name}[pinion, worst], or {name} alone"))
        return None
    if (bodies and "body" not in entry.dims) or (times and _STEPS not in entry.dims):
        word = bodies[0] if bodies and "body" not in entry.dims else times[0]
        problems.append(Problem(field, shown(text), f"{name} without [{word}]", f"{name} is one number for all"))
        return None
    return Quantity(str(text).strip(), entry, bodies[0] if bodies else "", times[0] if times else "end")


def unmet_needs(field: str, quantity: Quantity, scene: Scene, varied: Iterable[str] = ()) -> list[Problem]:
    """Problem of a quantity that results of a scene do not have; empty if they have it.

    Parameters
    ----------
    field : str
        Field that names the quantity, for the message.
    quantity : Quantity
    scene : Scene
    varied : iterable of str
        Dotted keys of varied fields; tables and fields that they add do not count as missing.
    """
    keys = [str(key) for key in varied]
    missing = [
        _needed(need, value)
        for need, value in quantity.variable.needs.items()
        if not _has(scene, need, value)
        and not any(f"{key}.".startswith(f"{need}.") or need.startswith(f"{key}.") for key in keys)
    ]
    if not missing:
        return []
    return [
        Problem(
            field,
            quantity.text,
            "a quantity that results of this scene have",
            f"its result has no {quantity.text}: give the scene {' and '.join(missing)}",
        )
    ]


def _has(scene: Scene, key: str, needed: bool | str) -> bool:
    value = scene_value(scene, key)
    if needed is True:
        return value is not None
    return needed in value if isinstance(value, list) else value == needed


def _needed(key: str, needed: bool | str) -> str:
    if needed is not True:
        return f'"{needed}" as {key}' if key != "wear.worn_bodies" else f'"{needed}" among wear.worn_bodies'
    return f"[{key}]" if any(key in schema.tables for schema in SCHEMAS.values()) else key


def measure_of_quantities(quantities: Sequence[Quantity]) -> Measure:
    """Variables to read off results for the quantities; only of the last wear state if none needs another.

    Peaks of the transmission error are found in the wear states that its amplitude is asked for.
    """
    paths = tuple(dict.fromkeys(quantity.path for quantity in quantities))
    times = {quantity.time for quantity in quantities if quantity.path == WITH_PEAKS}
    peaks = None if "worst" in times else tuple(_STATES[time] for time in sorted(times))
    return Measure(paths, last=all(quantity.time == "end" for quantity in quantities), peaks=peaks)


def limits_of(subject_to: object, problems: list[Problem]) -> tuple[Limit, ...]:
    """Limits from text such as ``{"transmission_error_amplitude": "<= 2.5"}``; several for a quantity in a list."""
    limits: list[Limit] = []
    if subject_to is None:
        return ()
    if not isinstance(subject_to, Mapping):
        fix = 'such as {"transmission_error_amplitude": "<= 2.5"}'
        problems.append(Problem("subject_to", shown(subject_to), "a mapping from quantities to limits", fix))
        return ()
    for name, given in subject_to.items():
        field = f"subject_to.{name}"
        quantity = quantity_of(field, name, problems)
        for text in (given,) if isinstance(given, str) or not isinstance(given, Sequence) else given:
            match = _LIMIT.fullmatch(text) if isinstance(text, str) else None
            if match is None or not isfinite(float(match["value"])):
                unit = f", in {quantity.units}" if quantity and quantity.units != "1" else ""
                allowed = f'a sign and a number in quotes, such as "<= 2.5" or ">= 1e8"{unit}'
                problems.append(Problem(field, shown(text), allowed, _meant_limit(text)))
            elif quantity is not None:
                limits.append(Limit(quantity, float(match["value"]), match["sign"] == "<="))
    return tuple(limits)


def _meant_limit(text: object) -> str:
    """Advice for a text that is not a limit: it has a decimal comma, a unit, another sign or none."""
    match = re.fullmatch(r"\s*([<>=≤≥]*)(.*)", str(text), re.DOTALL)
    value = None if match is None else meant_number(match[2])
    if match is None or value is None or not isfinite(float(value)):
        return "give a sign and a number"
    signs = [sign for sign, marks in (("<=", "<≤"), (">=", ">≥")) if set(match[1]) & set(marks)]
    meant = " or ".join(f'"{sign} {value}"' for sign in (signs if len(signs) == 1 else ("<=", ">=")))
    return f"did you mean {meant}?"

"""Rules of fields that need more than a range: moduli, depths, bodies, wear coefficients."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

from semiwear.references.named_data import WEAR, named_sets
from semiwear.scene.closest import advised_name, closest
from semiwear.scene.declare import declared
from semiwear.scene.rule import Rule, choice
from semiwear.scene.values import Unreadable, number, numbers, shown, text, texts
from semiwear.untyped import Value

BODIES = ("pinion", "gear")
"""Both bodies, in the order of a scene."""


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

    @property
    def given(self) -> dict[str, float]:
        """Coefficients by body."""
        return {body: value for body in BODIES if (value := getattr(self, body)) is not None}


@dataclass(frozen=True, kw_only=True)
class BodyData:
    """Names of data for bodies that differ; None for a body that has none.

    Attributes
    ----------
    pinion, gear : str or None
    """

    pinion: str | None = None
    gear: str | None = None

    @property
    def given(self) -> dict[str, str]:
        """Names by body."""
        return {body: name for body in BODIES if (name := getattr(self, body)) is not None}


_COEFFICIENTS = "a table {pinion = ..., gear = ...}"


def youngs_modulus() -> Rule:
    """Young's modulus from soft polymers to diamond, a range that reveals wrong units."""

    def fix(value: float) -> str:
        for unit, factor in (("GPa", 1e3), ("Pa", 1e-6)):
            if 0.5e3 <= factor * value <= 1.5e6:
                return f"this looks like {unit}: give {factor * value:g}; 207000 for steel"
        return "in MPa: 207000 for steel"

    return Rule(number, "500 to 1500000 MPa", lambda value: 500.0 <= value <= 1.5e6, fix)


def increasing_depths() -> Rule:
    """Depths above 0 that increase strictly."""

    def holds(depths: tuple[float, ...]) -> bool:
        return bool(depths) and depths[0] > 0.0 and all(a < b for a, b in pairwise(depths))

    def fix(depths: tuple[float, ...]) -> str:
        kept = sorted({depth for depth in depths if depth > 0.0})
        return f"give {[float(f'{depth:.6g}') for depth in kept]}" if kept else "give e.g. [5, 10, 15]"

    return Rule(numbers, "one or more depths in um, above 0 and strictly increasing", holds, fix)


def _bodies(raw: object) -> tuple[str, ...]:
    """A list of texts, sorted with the pinion first if all are bodies."""
    if isinstance(raw, str):
        meant = BODIES if raw.casefold() == "both" else (closest(raw, BODIES) or "gear",)
        raise Unreadable(f"give a list: {_listed(meant)}")
    bodies = texts(raw)
    return tuple(sorted(bodies, key=BODIES.index)) if set(bodies) <= set(BODIES) else bodies


def worn_bodies() -> Rule:
    """One body or both, the pinion first."""

    def holds(bodies: tuple[str, ...]) -> bool:
        return bool(bodies) and set(bodies) <= set(BODIES) and len(set(bodies)) == len(bodies)

    def fix(bodies: tuple[str, ...]) -> str:
        if not bodies:
            return 'give ["gear"]; for loaded contact without wear remove [wear]'
        meant = {body if body in BODIES else closest(body, BODIES) for body in bodies[:10]} - {None}
        return f"give {_listed(body for body in BODIES if body in meant)}" if meant else 'give ["gear"]'

    return Rule(_bodies, '["gear"] or ["pinion"] or ["pinion", "gear"]', holds, fix)


def watched_body() -> Value:
    """Field of a control point for the body on whose flank it lies."""
    meaning = "Body on whose flank the point lies; left out: the gear if it wears, else the pinion."
    return declared(choice(*BODIES), meaning, default=None)


def _listed(words: Iterable[str]) -> str:
    return "[" + ", ".join(f'"{word}"' for word in words) + "]"


def _coefficient(raw: object) -> float | BodyCoefficients:
    if isinstance(raw, BodyCoefficients):
        raw = raw.given
    if not isinstance(raw, Mapping):
        return number(raw)
    raw = {body: value for body, value in raw.items() if value is not None}
    foreign = [name for name in raw if name not in BODIES]
    if foreign or not raw:
        raise Unreadable(f"give {_COEFFICIENTS}{f', not {shown(foreign[0])}' if foreign else ''}")
    try:
        return BodyCoefficients(**{body: number(value) for body, value in raw.items()})
    except Unreadable as reason:
        raise Unreadable(f"for each body {reason}") from None


def _each(value: float | BodyCoefficients) -> tuple[float, ...]:
    """The coefficients that are given."""
    return tuple(value.given.values()) if isinstance(value, BodyCoefficients) else (value,)


_WEAR_COEFFICIENTS = (1e-16, 1e-5)
"""Range for any sliding pair [mm2/N]. Archard's number K = k times hardness is 1e-8 to 1e-2 for metals (Archard and
Hirst 1956), which at 200 to 10,000 MPa makes k 1e-12 to 5e-5; for lubricated gears it is as low as 1e-13 (Andersson
and Flodin)."""

USUAL_WEAR_COEFFICIENTS = (1e-14, 1e-7)
"""Range from well lubricated hard steel to dry plastics [mm2/N]; beyond it, the unit is probably wrong."""

_USUAL_COEFFICIENT = "1e-13 to 1e-9 mm2/N is usual of lubricated steel, 1e-9 to 1e-7 of plastics"


def wear_coefficient() -> Rule:
    """Wear coefficient of any sliding pair, a range that reveals wrong units."""
    least, most = _WEAR_COEFFICIENTS

    def holds(value: float | BodyCoefficients) -> bool:
        return all(least <= coefficient <= most for coefficient in _each(value))

    def fix(value: float | BodyCoefficients) -> str:
        wrong = next(coefficient for coefficient in _each(value) if not least <= coefficient <= most)
        if wrong <= 0.0:
            return f"give a positive number: {_USUAL_COEFFICIENT}"
        if wrong < least:
            return f"{wrong:g} looks like m2/N: give {1e6 * wrong:g}; {_USUAL_COEFFICIENT}"
        return f"{wrong:g} looks like Archard's number: divide it by the hardness in MPa; {_USUAL_COEFFICIENT}"

    allowed = f"{least:g} to {most:g} mm2/N, or {_COEFFICIENTS}"
    return Rule(_coefficient, allowed, holds, fix)


def _named_otherwise(kind: str) -> str:
    listing = "semiwear materials lists them with their sources"
    return f'any steel, hardened or not, is "steel"; {listing}' if "steel" in named_sets(kind) else listing


def named_data(kind: str, meaning: str) -> Value:
    """Field that names a set of data of a kind; `semiwear materials` lists all sets."""
    names = tuple(named_sets(kind))
    return declared(choice(*names, otherwise=_named_otherwise(kind)), meaning, default=None)


def wear_data() -> Rule:
    """A named wear coefficient, or a name for each body."""
    names = tuple(named_sets(WEAR))

    def read(raw: object) -> str | BodyData:
        if isinstance(raw, BodyData):
            return raw
        if not isinstance(raw, Mapping):
            return text(raw)
        given = {body: name for body, name in raw.items() if name is not None}
        if not given or set(given) - set(BODIES):
            raise Unreadable(f"give a name or {_COEFFICIENTS}")
        return BodyData(**{body: text(name) for body, name in given.items()})

    def each(value: str | BodyData) -> Iterable[str]:
        return value.given.values() if isinstance(value, BodyData) else (value,)

    def fix(value: str | BodyData) -> str:
        meant = [known for name in each(value) if name not in names and (known := closest(name, names))]
        return f'did you mean "{meant[0]}"?' if meant else "semiwear materials lists them with their sources"

    allowed = f"one of {', '.join(names)}, or {_COEFFICIENTS}"
    return Rule(read, allowed, lambda value: all(name in names for name in each(value)), fix)


def tooth_compliance() -> Rule:
    """A compliance model, or a file of influence data."""
    words = ("prism", "rigid")

    def fix(value: str) -> str:
        return advised_name(value, words, 'give "prism", or a file that ends with .nc', quoted=True)

    allowed = '"prism" or "rigid" or a netCDF file of influence data'

    def is_file(value: str) -> bool:
        return value not in words

    return Rule(text, allowed, lambda value: value in words or value.endswith(".nc"), fix, is_file)

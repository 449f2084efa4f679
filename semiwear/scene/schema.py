"""Where each field lives: the tables of a scene file and the dataclasses behind them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, asdict, fields
from typing import Any

from semiwear.scene.defaults import DERIVED_DEFAULTS
from semiwear.scene.effects import EFFECTS, Effects, Modifications, WearLaws
from semiwear.scene.gear_pair import FaceGearPair
from semiwear.scene.model import (
    BodyCoefficients,
    Check,
    ControlPoint,
    Material,
    Materials,
    Numerics,
    Operation,
    Scene,
    Wear,
    WearUntil,
)
from semiwear.scene.rules import RULES

__all__ = [
    "DEFAULTS",
    "DERIVED_KEYS",
    "INLINE_TABLES",
    "NEVER_EMPTY",
    "OPTIONAL_TABLES",
    "REQUIRED",
    "TABLES",
    "build",
    "children",
    "fields_of",
    "parent",
    "to_dict",
]

TABLES: dict[str, type] = {
    "": Scene,
    "gear_pair": FaceGearPair,
    "material": Materials,
    "material.pinion": Material,
    "material.gear": Material,
    "operation": Operation,
    "wear": Wear,
    "wear.until": WearUntil,
    "wear.control_point": ControlPoint,
    "numerics": Numerics,
    "effects": Effects,
    "effects.modification": Modifications,
    "effects.wear_law": WearLaws,
} | {f"effects.{name}": table for name, table in EFFECTS.items()}
OPTIONAL_TABLES = ("wear", "wear.control_point", *(f"effects.{name}" for name in EFFECTS))
# These only hold effects: written without any, they would do nothing and look as if they did.
NEVER_EMPTY = ("effects.modification", "effects.wear_law")
INLINE_TABLES = ("wear.coefficient_mm2_per_N",)
DERIVED_KEYS = frozenset(f"gear_pair.{name}" for name in DERIVED_DEFAULTS)


def parent(key: str) -> str:
    """The table of a dotted key; the empty string is the top level."""
    return key.rpartition(".")[0]


def fields_of(table: str) -> list[str]:
    """Dotted keys of the values that stand directly in a table."""
    return [key for key in RULES if parent(key) == table]


def children(table: str) -> list[str]:
    """Dotted keys of all that may stand directly in a table: values, then tables."""
    return fields_of(table) + [name for name in TABLES if name and parent(name) == table]


def _declared_defaults() -> dict[str, Any]:
    declared = {(table, entry.name): entry.default for table, owner in TABLES.items() for entry in fields(owner)}
    return {key: declared[parent(key), key.rpartition(".")[2]] for key in RULES}


_DECLARED = _declared_defaults()
REQUIRED = frozenset(key for key, default in _DECLARED.items() if default is MISSING)
DEFAULTS: dict[str, Any] = {
    key: default for key, default in _DECLARED.items() if key not in REQUIRED and key not in DERIVED_KEYS
}


def build(values: Mapping[str, Any], tables: Collection[str], check: Check | None = None) -> Scene:
    """A scene.

    Parameters
    ----------
    values : mapping
        Values under their dotted keys; what is left out takes its default.
    tables : collection of str
        The tables that are there: an empty one is an effect too.
    check : callable, optional
        Kept with the scene, for `Scene.replace`.
    """

    def arguments(table: str) -> dict[str, Any]:
        return {key.rpartition(".")[2]: values[key] for key in fields_of(table) if key in values}

    def present(container: str) -> dict[str, Any]:
        keys = [key for key in children(container) if key in tables and key in OPTIONAL_TABLES]
        return {key.rpartition(".")[2]: TABLES[key](**arguments(key)) for key in keys}

    wear = None
    if "wear" in tables:
        watched = arguments("wear.control_point")
        wear = Wear(
            until=WearUntil(**arguments("wear.until")),
            control_point=ControlPoint(**watched) if watched else None,
            **arguments("wear"),
        )
    return Scene(
        gear_pair=FaceGearPair(**arguments("gear_pair")),
        material=Materials(
            pinion=Material(**arguments("material.pinion")), gear=Material(**arguments("material.gear"))
        ),
        operation=Operation(**arguments("operation")),
        wear=wear,
        numerics=Numerics(**arguments("numerics")),
        effects=Effects(
            modification=Modifications(**present("effects.modification")),
            wear_law=WearLaws(**present("effects.wear_law")),
            **present("effects"),
        ),
        _check=check,
        **arguments(""),
    )


def to_dict(scene: Scene, *, without_derived: bool = False) -> dict[str, Any]:
    """The scene as nested dicts of plain values; None and absent tables are left out.

    Parameters
    ----------
    scene : Scene
        The scene.
    without_derived : bool
        Leave out what was left to its derived default.
    """
    nested: dict[str, Any] = {}
    hidden = {f"gear_pair.{name}" for name in scene.gear_pair._derived} if without_derived else set()
    for key, value in _flat(scene):
        if value is None or key in hidden:
            continue
        *path, name = key.split(".")
        table = nested
        for step in path:
            table = table.setdefault(step, {})
        # Read once more: the constructors accept module_mm=6, and equal scenes must be written alike.
        table[name] = _plain(RULES[key].read(value))
    return nested


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, BodyCoefficients):
        return {body: one for body, one in asdict(value).items() if one is not None}
    return value


def _flat(scene: Scene) -> Iterator[tuple[str, Any]]:
    for key in RULES:
        value: Any = scene
        for step in key.split("."):
            value = None if value is None else getattr(value, step)
        yield key, value

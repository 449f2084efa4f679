"""A scene with some fields changed: `Scene.replace`."""

from __future__ import annotations

from collections.abc import Mapping

from semiwear.errors import Problem
from semiwear.scene.closest import closeness
from semiwear.scene.model import SceneTables
from semiwear.scene.named_data import NAMING, dropped_with
from semiwear.scene.reading import MOST_UNKNOWN, more_unknown, unknown_key
from semiwear.scene.schema import NEVER_EMPTY, SCHEMAS, Schema, parent, schema_of_data, to_dict
from semiwear.untyped import Table, Value

# Setting one of these ends of a run removes the others.
_ENDS = ("wear.until.meshes", "wear.until.hours", "wear.until.control_depths_um")


def edited(scene: Mapping[str, Value], changes: Mapping[str, Value]) -> tuple[Table, list[Problem]]:
    """Nested mappings of a scene with dotted keys set to new values, or removed by None; problems of unknown keys.

    The scene, nested mappings as of `to_dict` without derived values, need not be a valid one.
    """
    data = dict(scene)
    schema = schema_of_data(data)
    kind = changes.get("gear_pair.type")
    schema = SCHEMAS.get(kind, schema) if isinstance(kind, str) else schema
    problems: list[Problem] = []
    unknown: list[Value] = []
    for key, value in changes.items():
        if not isinstance(key, str) or (key not in schema.rules and key not in schema.tables) or not key:
            unknown.append(key)
            if len(unknown) <= MOST_UNKNOWN:
                problems.append(_unknown(str(key), value, schema))
            continue
        if key in NAMING and isinstance(value, str):
            key = f"{key}.data"
        for other in dropped_with(key):
            if other not in changes:
                _set(data, other, None)
        _set(data, key, value)
        for rival in _ENDS if key in _ENDS and value is not None else ():
            if rival != key and changes.get(rival) is None:
                _set(data, rival, None)
    if len(unknown) > MOST_UNKNOWN:
        problems.append(more_unknown(str(unknown[MOST_UNKNOWN]), len(unknown) - MOST_UNKNOWN))
    return data, problems


def unknown_field(scene: SceneTables | None, key: str, value: Value) -> list[Problem]:
    """The problem of a dotted key that the scene cannot have, given a value; none of one that it can.

    Without a scene: of a key that a scene of no kind of gear pair can have.
    """
    if scene is not None:
        return edited(to_dict(scene, without_derived=True), {key: value})[1]
    if key and any(key in schema.rules or key in schema.tables for schema in SCHEMAS.values()):
        return []
    nearest = max(SCHEMAS.values(), key=lambda schema: max(closeness(key, own) for own in schema.rules))
    return [_unknown(key, value, nearest)]


def _set(data: Table, key: str, value: Value) -> None:
    *path, name = key.split(".")
    table = data
    for step in path:
        inner = table.get(step)
        # Removing a field must not create its table, since the presence of a table has a meaning.
        if inner is None and value is None:
            return
        # Copied, since the table may belong to the caller; any other value is replaced by a table.
        table[step] = dict(inner) if isinstance(inner, Mapping) else {}
        table = table[step]
    if value is not None:
        table[name] = value
        return
    table.pop(name, None)
    if not table and parent(key) in NEVER_EMPTY:
        _set(data, parent(key), None)


def _unknown(key: str, value: Value, schema: Schema) -> Problem:
    table = parent(key)
    while table not in schema.tables:
        table = parent(table)
    return unknown_key(table, key[len(table) :].removeprefix("."), value, schema)

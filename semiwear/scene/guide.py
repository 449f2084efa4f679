"""Help for writing a scene: a list of its fields, a commented scene to start from, a schema for editors.

All of it is derived from the declarations of the fields.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields
from importlib import resources
from pathlib import Path

from semiwear.errors import SceneError
from semiwear.scene.closest import advised_name
from semiwear.scene.effects import EFFECTS
from semiwear.scene.load import load_scene
from semiwear.scene.named_data import NAMING
from semiwear.scene.schema import INLINE_TABLES, OPTIONAL_TABLES, SCHEMAS, Schema
from semiwear.scene.toml_io import flat, read_toml, write_toml
from semiwear.scene.units import unit_of
from semiwear.untyped import Table, Value

EXAMPLES = {"face_gear": "face_gear_25x160", "cylindrical": "spur_fzg_c"}
"""Shipped scenes from which a new scene of the kind takes its values."""

_WIDTH = 100
_TYPES = {"float": "number", "int": "integer", "str": "string", "bool": "boolean", "tuple": "array"}


@dataclass(frozen=True)
class FieldNote:
    """Description of a field.

    Attributes
    ----------
    key : str
        Dotted key.
    unit : str
        ``"1"`` for a pure number or text.
    kind : str
        Type, as declared.
    default : object
        `dataclasses.MISSING` for a required field, None for an optional one.
    derived : bool
        Whether its default follows from other fields.
    allowed, meaning : str
        Allowed values and meaning in words.
    choices : tuple
        All values, if they are listed.
    """

    key: str
    unit: str
    kind: str
    default: object
    derived: bool
    allowed: str
    meaning: str
    choices: tuple[str, ...]

    @property
    def default_text(self) -> str:
        """Default in words."""
        if self.derived:
            return "follows"
        if self.default is MISSING:
            return "required"
        return "none" if self.default is None else _written(self.default)


def _written(value: Value) -> str:
    """A value as TOML text."""
    return write_toml({"value": list(value) if isinstance(value, tuple) else value}).strip().removeprefix("value = ")


def _schema(kind: str) -> Schema:
    if kind not in SCHEMAS:
        raise SceneError.of("kind", kind, ", ".join(SCHEMAS), advised_name(kind, SCHEMAS, "choose one of them"))
    return SCHEMAS[kind]


def field_notes(kind: str, table: str | None = None) -> list[FieldNote]:
    """Fields that a scene of a kind may have, in the order in which a scene is written.

    Parameters
    ----------
    kind : str
        ``"face_gear"``, ``"cylindrical"`` or ``"flank_points"``.
    table : str, optional
        Only fields of this table and of those within it.

    Raises
    ------
    SceneError
        There is no such kind or table.
    """
    schema = _schema(kind)
    if table is not None and not any(name == table or name.startswith(f"{table}.") for name in schema.tables):
        names = [name for name in schema.tables if name]
        raise SceneError.of("table", table, ", ".join(names), advised_name(table, names, "choose one"))
    declared = {
        f"{name}.{entry.name}" if name else entry.name: (str(entry.type), str(entry.metadata.get("meaning", "")))
        for name, owner in schema.tables.items()
        for entry in fields(owner)
    }
    notes = []
    for key, rule in schema.rules.items():
        if table is not None and not key.startswith(f"{table}."):
            continue
        type_, meaning = declared.get(key, ("str", "Kind of gear pair."))
        texts = re.findall(r'"([^"]+)"', rule.allowed)
        choices = tuple(text for text in texts if rule.apply(key, text)[1] is None) if "str" in type_ else ()
        default = schema.declared.get(key, MISSING)
        notes.append(
            FieldNote(key, unit_of(key), type_, default, key in schema.derived_keys, rule.allowed, meaning, choices)
        )
    return notes


def fields_text(kind: str, table: str | None = None) -> str:
    """`field_notes` as text: a line with a field's key, unit and default, below it its meaning and allowed values."""
    lines = []
    for note in field_notes(kind, table):
        unit = "" if note.unit == "1" else f" [{note.unit}]"
        lines.append(f"{note.key}{unit}: {note.default_text}")
        lines.append(textwrap.fill(f"{note.meaning} Allowed: {note.allowed}.", _WIDTH, initial_indent="    ",
                                   subsequent_indent="    "))  # fmt: skip
    return "\n".join(lines)


def new_scene(kind: str, folder: str = "") -> str:
    """A commented scene of a kind as TOML: the values of an example, and all other fields commented out.

    For flanks given as points it names two files in `folder`, which `semiwear new` writes there.

    Raises
    ------
    SceneError
        There is no such kind.
    """
    schema = _schema(kind)
    notes: dict[str, list[FieldNote]] = {}
    for note in field_notes(kind):
        notes.setdefault(note.key.rpartition(".")[0], []).append(note)
    given, filled = _example(kind, folder)
    lines = [
        f"# A scene of kind {kind}. Units are in the names. Fields that are commented out are optional and shown",
        "# with their defaults. `semiwear check FILE` lists every limit of the teeth, `semiwear geometry FILE` draws",
        "# them, `semiwear plan FILE` shows what will run, `semiwear run FILE -o worn.nc` runs it.",
    ]
    for table, own in notes.items():
        optional = table in OPTIONAL_TABLES and not any(note.key in given for note in own)
        if table:
            header = f"[{table}]"
            about = (schema.tables[table].__doc__ or "").partition("\n")[0].replace("``", "")
            lines += ["", *textwrap.wrap(about, _WIDTH, initial_indent="# ", subsequent_indent="# ")]
            if table.startswith("effects."):
                lines.append("# An effect is active if its table is present: remove the # before the header.")
            lines.append(f"# {header}" if optional else header)
        for note in own:
            lines += _field_lines(note, given, filled)
    return "\n".join(lines) + "\n"


def _field_lines(note: FieldNote, given: Table, filled: Table) -> Iterator[str]:
    name = note.key.rpartition(".")[2]
    yield from textwrap.wrap(
        f"{note.meaning} Allowed: {note.allowed}.", _WIDTH, initial_indent="# - ", subsequent_indent="#   "
    )
    if note.key in given:
        yield f"{name} = {_inline(note.key, given[note.key])}"
    elif note.key in filled and (note.derived or note.key.startswith(NAMING)):
        yield f"# {name} = {_inline(note.key, filled[note.key])}"
    else:
        known = note.default is not MISSING and note.default is not None and note.default != ()
        yield f"# {name} = {_written(note.default) if known else ''}".rstrip()


def _inline(key: str, value: Value) -> str:
    inline = ("value",) if key in INLINE_TABLES else ()
    return write_toml({"value": value}, inline=inline).strip().removeprefix("value = ")


def _example(kind: str, folder: str) -> tuple[Table, Table]:
    """Values given by an example of the kind, and all its values with defaults, by dotted key."""
    name = EXAMPLES.get(kind, EXAMPLES["cylindrical"])
    text = resources.files("semiwear.scene").joinpath("scenes", f"{name}.toml").read_text(encoding="utf-8")
    given = dict(flat(read_toml(text, name), inline=INLINE_TABLES))
    given.pop("reference", None)
    given["title"] = f"My {kind.replace('_', ' ')} pair"
    steel = dict.fromkeys(NAMING, "steel")
    filled = dict(flat(load_scene(name).replace(steel).to_dict(), inline=INLINE_TABLES))
    given = {key: value for key, value in given.items() if not key.startswith("material.")}
    given |= {f"{table}.data": value for table, value in steel.items()}
    if kind in EXAMPLES:
        return given, filled
    pair: Table = {"type": kind, **{f"{body}_file": str(Path(folder, f"{body}.nc")) for body in ("pinion", "gear")}}
    pair |= {name: given[f"gear_pair.{name}"] for name in ("pinion_teeth", "gear_teeth")}
    pair |= {"gear_axis_point_mm": [0.0, -filled["gear_pair.centre_distance_mm"], 0.0]}
    pair |= {"gear_axis_direction": [0.0, 0.0, 1.0], "pinion_rotation": "negative", "gear_rotation": "positive"}
    given = {key: value for key, value in given.items() if not key.startswith("gear_pair.")}
    return given | {f"gear_pair.{name}": value for name, value in pair.items()}, filled


def json_schema() -> Table:
    """JSON schema (draft 7) of scene files, for completion and help in editors."""
    root: Table = {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "semiwear scene",
        "type": "object",
        "properties": {},
        "additionalProperties": False,
    }
    for kind in SCHEMAS:
        for note in field_notes(kind):
            *tables, name = note.key.split(".")
            where = root["properties"]
            for table in tables:
                inner = where.setdefault(table, {"type": "object", "properties": {}, "additionalProperties": False})
                where = inner["properties"]
            entry = where.setdefault(name, _property(note))
            if kind not in entry.setdefault("x-kinds", []):
                entry["x-kinds"].append(kind)
    for table in NAMING:  # a name may replace the table
        material, body = table.split(".")
        root["properties"][material]["properties"][body]["type"] = ["object", "string"]
    for effect in EFFECTS:
        where = root["properties"].setdefault("effects", {"type": "object", "properties": {}})["properties"]
        for table in effect.split("."):
            inner = where.setdefault(table, {"type": "object", "properties": {}, "additionalProperties": False})
            where = inner["properties"]
    return root


def _property(note: FieldNote) -> Table:
    kinds = [json for name, json in _TYPES.items() if re.search(rf"\b{name}\b", re.sub(r"\[.*?\]", "", note.kind))]
    if note.key in INLINE_TABLES:
        kinds.append("object")
    unit = "" if note.unit == "1" else f" [{note.unit}]"
    schema: Table = {"description": f"{note.meaning}{unit} Allowed: {note.allowed}.".strip()}
    if len(kinds) == 1:
        schema["type"] = kinds[0]
    elif kinds:
        schema["type"] = kinds
    if note.choices and kinds == ["string"]:
        schema["enum"] = list(note.choices)
    if note.default is not MISSING and note.default is not None and not note.derived:
        schema["default"] = list(note.default) if isinstance(note.default, tuple) else note.default
    return schema

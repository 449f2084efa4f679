"""Pages of scene fields, from their declarations: unit, default, allowed values and source of every field."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import MISSING
from inspect import cleandoc

import semiwear as sw
from semiwear.scene.effects import EFFECTS
from semiwear.scene.guide import EXAMPLES, FieldNote, field_notes
from semiwear.scene.schema import SCHEMAS
from semiwear.untyped import Table, Value

_KINDS = {
    "face_gear": "face gears",
    "cylindrical": "cylindrical gears",
    "flank_points": "flanks given as points",
}
_INTRODUCTION = """\
Every field is declared once, in the package; this page is made of those declarations. `semiwear fields` prints the
same list, and {download}`scene.schema.json <../../scene.schema.json>` is the same for editors. Where a default
*follows* from other fields, its value in the shipped scene of that kind is given.
"""


def field_pages() -> dict[str, str]:
    """File names and texts: a page for each kind of gear pair, and one for what all kinds have."""
    notes = {kind: {note.key: note for note in field_notes(kind)} for kind in SCHEMAS}
    common = [key for key in next(iter(notes.values())) if all(key in of for of in notes.values())]
    common = [key for key in common if len({notes[kind][key] for kind in notes}) == 1 and key != "gear_pair.type"]
    pages = {
        "fields_all.md": _page("Fields of every scene", "cylindrical", [notes["cylindrical"][key] for key in common])
    }
    for kind, own in notes.items():
        rest = [note for key, note in own.items() if key not in common]
        pages[f"fields_{kind}.md"] = _page(f"Fields of {_KINDS.get(kind, kind)}", kind, rest)
    return pages


def _page(title: str, kind: str, notes: list[FieldNote]) -> str:
    tables: dict[str, list[FieldNote]] = {}
    for note in notes:
        tables.setdefault(note.key.rpartition(".")[0], []).append(note)
    example = sw.load_scene(EXAMPLES[kind]).to_dict() if kind in EXAMPLES else {}
    lines = [f"# {title}", "", _INTRODUCTION]
    for table, own in tables.items():
        owner = SCHEMAS[kind].tables[table]
        lines += [f"## `[{table}]`" if table else "## At the top of the file", "", _about(owner), ""]
        if sources := getattr(owner, "references", ()):
            lines += ["Source: " + "; ".join(sources) + ".", ""]
        for note in own:
            lines += _entry(note, kind, example)
    return "\n".join(lines) + "\n"


def _about(owner: type) -> str:
    """First sentence of a table's docstring, without the table's name."""
    text = cleandoc(owner.__doc__ or "").partition("\n\n")[0].replace("\n", " ").replace("``", "`")
    _, colon, rest = text.partition(": ")
    rest = rest if colon and text.startswith("Table") else text
    return rest[:1].upper() + rest[1:]


def _entry(note: FieldNote, kind: str, example: Table) -> Iterator[str]:
    name = note.key.rpartition(".")[2]
    unit = "" if note.unit == "1" else f" · {note.unit}"
    yield f"`{name}`{unit} · {_default(note, kind, example)}"
    yield f": {note.meaning} Allowed: {note.allowed}."
    yield ""


def _default(note: FieldNote, kind: str, example: Table) -> str:
    if not note.derived:
        if note.default is MISSING:
            return "**required**"
        return "may be left out" if note.default is None else f"default `{note.default_text}`"
    derived = SCHEMAS[kind].derived[note.key.rpartition(".")[2]]
    told = "follows from " + ", ".join(f"`{need}`" for need in derived.needs)
    pair: Mapping[str, Value] = example.get("gear_pair", {})
    if all(need in pair for need in derived.needs):
        told += f" (`{derived.formula(*(pair[need] for need in derived.needs)):.6g}` in `{EXAMPLES[kind]}`)"
    return told


def effects_page() -> str:
    """What each effect is, where it acts, what it needs, within which range it holds, and by whom."""
    lines = [
        "# Effects, their needs and their range of validity",
        "",
        "Made of the declarations of the tables under `[effects]`. What each is worth in numbers is on "
        "[](../../effects.md); their fields are on [](fields_all.md).",
        "",
    ]
    for name, table in EFFECTS.items():
        needs = ", ".join(f"`{key}`" for key in table.needs) or "nothing else"
        lines += [
            f"## `[effects.{name}]`: {table.title}",
            "",
            _about(table),
            "",
            f"- acts in: {table.acts_in}",
            f"- needs: {needs}",
            f"- valid for: {table.validity}",
            *(f"- source: {source}" for source in table.references),
            "",
        ]
    return "\n".join(lines)

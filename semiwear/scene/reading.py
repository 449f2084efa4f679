"""First look at a scene file: every field by itself, and every name."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from semiwear.errors import Problem
from semiwear.scene.closest import closeness
from semiwear.scene.schema import NEVER_EMPTY, OPTIONAL_TABLES, SCHEMAS, Schema, last_of, parent
from semiwear.scene.values import shown
from semiwear.untyped import Table, Value

# A name from the same table is a likelier meaning than an equally close one from elsewhere.
_SAME_TABLE_BONUS = 0.1
# Effects are many: from elsewhere, a name of theirs is meant only if nothing else is.
_EFFECT_MALUS = 0.2
_MOST_MEANINGS = 3
_TYPE = "gear_pair.type"
# Symbols and words of drawings, textbooks and other programs, in small letters without underscores or unit, and the
# fields that they stand for.
_OTHER_NAMES = {
    "z1": ("pinion_teeth",),
    "z2": ("gear_teeth",),
    "ratio": ("gear_teeth",),
    "m": ("normal_module_mm", "module_mm"),
    "mn": ("normal_module_mm",),
    "alpha": ("pressure_angle_deg",),
    "alphan": ("pressure_angle_deg",),
    "beta": ("helix_angle_deg",),
    "x1": ("pinion_profile_shift",),
    "x2": ("gear_profile_shift",),
    "b": ("pinion_face_width_mm",),
    "b1": ("pinion_face_width_mm",),
    "b2": ("gear_face_width_mm",),
    "a": ("centre_distance_mm",),
    "aw": ("centre_distance_mm",),
    "da1": ("pinion_tip_diameter_mm",),
    "da2": ("gear_tip_diameter_mm",),
    "sigma": ("shaft_angle_deg",),
    "e": ("youngs_modulus_MPa", "pinion.youngs_modulus_MPa"),
    "nu": ("poissons_ratio", "pinion.poissons_ratio"),
    "t": ("pinion_torque_Nm",),
    "t1": ("pinion_torque_Nm",),
    "n": ("pinion_speed_rpm",),
    "n1": ("pinion_speed_rpm",),
    "rpm": ("pinion_speed_rpm",),
    "k": ("coefficient_mm2_per_N",),
    "kw": ("coefficient_mm2_per_N",),
    "mu": ("coefficient",),
    "lifetime": ("hours",),
    "cycles": ("meshes",),
    "revolutions": ("meshes",),
    "ca": ("tip_relief_um",),
    "calphaa": ("tip_relief_um",),
    "lca": ("tip_relief_length_mm",),
    "cf": ("root_relief_um",),
    "calphaf": ("root_relief_um",),
    "cbeta": ("crowning_um",),
    "chbeta": ("lead_slope_um",),
}
_UNIT = re.compile(r"_(mm|um|deg|rad|nm|knm|rpm|mpa|gpa)$")  # ends of names, in small letters
# Names of a rating that no scene has the inputs of, in small letters.
_OF_WORMS = frozenset({"din_3996", "din3996", "iso_14521", "iso_ts_14521", "worm", "worm_wear"})
# Of more unknown names, those that follow are counted: to find out what each may mean takes a millisecond and more.
MOST_UNKNOWN = 20


@dataclass
class Reading:
    """Content of a scene file, field by field.

    Attributes
    ----------
    schema : Schema
        The fields that the scene may hold.
    given : dict
        Dotted key to value, for every field that is there and in its range.
    refused : set of str
        Dotted keys of the fields and tables that are there, but wrong.
    tables : set of str
        The tables that are there.
    problems : list of Problem
        What is wrong so far.
    """

    schema: Schema
    given: Table = field(default_factory=dict)
    refused: set[str] = field(default_factory=set)
    tables: set[str] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)

    def has(self, key: str) -> bool:
        """Whether the file says something, right or wrong, about a field or table."""
        return key in self.given or key in self.refused or key in self.tables

    def lacks(self, key: str) -> bool:
        """Whether a field is absent although the table that holds it is there, or would be by default."""
        return not self.has(key) and self._expects(parent(key))

    @property
    def complete(self) -> bool:
        """Whether every field that is there is in its range, and every required one is there."""
        return not self.refused and not any(self.lacks(key) for key in self.schema.required)

    def _expects(self, table: str) -> bool:
        if table in self.tables or table in self.refused:
            return table in self.tables
        return table not in OPTIONAL_TABLES and self._expects(parent(table))


def read_fields(data: Mapping[str, Value], schema: Schema, *, kind_is_known: bool = True) -> Reading:
    """Read every field of a nested mapping by its own rule; report wrong values, unknown names and gaps.

    Parameters
    ----------
    data : mapping
    schema : Schema
    kind_is_known : bool
        Whether no other kind of gear pair may be meant: fields of one that may not be are not asked for.
    """
    reading = Reading(schema)
    unknown: deque[tuple[str, str, Value]] = deque()
    _read_table("", data, reading, unknown)
    for _ in range(MOST_UNKNOWN):
        if unknown:
            _read_unknown(*unknown.popleft(), reading, unknown)
    if unknown:
        table, name, _ = unknown[0]
        reading.problems.append(more_unknown(f"{table}.{name}" if table else name, len(unknown)))
    for key in sorted(schema.required, key=list(schema.rules).index):
        table = parent(key)
        asked_for = kind_is_known or key == _TYPE or table != parent(_TYPE)
        if asked_for and reading.lacks(key) and f"{table}.data" not in reading.refused:
            fix = _missing_fix(key, schema, kind_is_known)
            reading.problems.append(Problem(key, None, schema.rules[key].allowed, fix))
    return reading


def _missing_fix(key: str, schema: Schema, kind_is_known: bool) -> str:
    table = parent(key)
    if key == _TYPE and not kind_is_known:
        return "say first which kind it is, its fields follow from that (semiwear fields --kind KIND lists them)"
    if key == _TYPE:
        return f'its fields are those of such a pair: add type = "{schema.kind}"'
    named = f", or {table}.data (semiwear materials)" if f"{table}.data" in schema.rules else ""
    return f"needed by [{table}]: add it{named}"


def _read_table(table: str, raw: Value, reading: Reading, unknown: deque[tuple[str, str, Value]]) -> None:
    if not isinstance(raw, Mapping):
        reading.refused.add(table)
        reading.problems.append(Problem(table, shown(raw), "a table", _table_fix(table, reading.schema)))
        return
    reading.tables.add(table)
    if table in NEVER_EMPTY and all(value is None for value in raw.values()):
        reading.refused.add(table)
        allowed = f"a table with one or more of {', '.join(map(last_of, reading.schema.children(table)))}"
        reading.problems.append(Problem(table, shown(dict(raw)), allowed, _table_fix(table, reading.schema)))
    for name, value in raw.items():
        if value is None:  # TOML has no null: a caller's None stands for a field left out
            continue
        key = f"{table}.{name}" if table else str(name)
        # A quoted name with a dot in it must not pass for a path.
        known = isinstance(name, str) and name != "" and "." not in name
        if known and key in reading.schema.rules:
            _read_value(key, value, reading)
        elif known and key in reading.schema.tables:
            _read_table(key, value, reading, unknown)
        else:
            unknown.append((table, str(name), value))


def _table_fix(table: str, schema: Schema) -> str:
    if table in NEVER_EMPTY or table == "effects":
        examples = [child for child in schema.tables if child.startswith(f"{table}.") and child not in NEVER_EMPTY]
        return f"write the header of an effect, e.g. [{examples[0]}], or leave it out"
    if table.startswith("effects."):
        return (
            f"write the header [{table}]; an effect runs if its table is there, even an empty one. "
            f"To remove it, leave the table out (on the command line --set {table}=none)"
        )
    return f"write the header [{table}] above its fields"


def _read_value(key: str, raw: Value, reading: Reading) -> None:
    value, problem = reading.schema.rules[key].apply(key, raw)
    if problem is None:
        reading.given[key] = value
    else:
        reading.refused.add(key)
        reading.problems.append(problem)


def _read_unknown(
    table: str, name: str, raw: Value, reading: Reading, unknown: deque[tuple[str, str, Value]]
) -> None:
    schema = reading.schema
    meanings = _meanings(table, name, schema)
    meant = meanings[0] if len(meanings) == 1 else None
    problem = unknown_key(table, name, raw, schema)
    if meant is not None and not reading.has(meant):
        if meant in schema.required and reading.lacks(meant):
            problem = Problem(problem.field, problem.value, problem.allowed, f"{problem.fix} It is missing.")
        # Read on under the name that was meant, so that its value is tested in the same go.
        if meant in schema.tables and isinstance(raw, Mapping):
            _read_table(meant, raw, reading, unknown)
        elif meant in schema.rules:
            _read_value(meant, raw, reading)
    reading.problems.append(problem)


def more_unknown(key: str, count: int) -> Problem:
    """The problem of unknown names that follow many others, of which this is the first."""
    return Problem(str(shown(key)), f"{count} more unknown names", "names of a scene", "is this the file of a scene?")


def unknown_key(table: str, name: str, raw: Value, schema: Schema) -> Problem:
    """The problem of a name that no table of a scene has."""
    key = f"{table}.{name}" if table else name or '""'
    meanings = _meanings(table, name, schema)
    where = f"[{table}]" if table else "the top level"
    allowed = f"a name of {where}"
    if len(meanings) != 1:
        allowed += f": {', '.join(map(last_of, schema.children(table)))}"
    if name.casefold() in _OF_WORMS:
        fix = (
            "remove it: that wear safety is of worm gears, whose inputs a scene does not have (docs/failure_modes.md)"
        )
        return Problem(key, shown(raw), f"a name of {where}", fix)
    if meanings:
        near = (last_of(meant) if parent(meant) == table else meant for meant in meanings)
        fix = f"did you mean {' or '.join(near)}?"
    else:
        others = _kinds_with(key)
        fix = f'remove it: it is of gear_pair.type = "{others[0]}"' if others else "remove it"
    return Problem(key, shown(raw), allowed, fix)


def _meanings(table: str, name: str, schema: Schema) -> list[str]:
    """Dotted keys of the fields and tables that a misspelled or misplaced name may stand for; few, or none."""
    symbol = _UNIT.sub("", name.casefold()).replace("_", "")
    keys = (f"{table}.{meant}" for meant in _OTHER_NAMES.get(symbol, ()))
    if known := [key for key in keys if key in schema.rules]:
        return known
    scores = {key: _likelihood(table, name, key) for key in (*schema.rules, *schema.tables) if key}
    best = max(scores.values())
    if best < 1.0 and _kinds_with(f"{table}.{name}"):  # spelled well, of another kind of pair
        return []
    if best < 1.0 and (known := _with_the_words(table, name, schema)):
        return known
    likeliest = [key for key, score in scores.items() if score == best]
    # of several that are as close, a field that every scene must give is the likelier meaning
    needed = [key for key in likeliest if key in schema.required]
    likeliest = needed if len(needed) == 1 else likeliest
    return likeliest if best > 0.0 and len(likeliest) <= _MOST_MEANINGS else []


def _with_the_words(table: str, name: str, schema: Schema) -> list[str]:
    """Dotted keys of the few fields that have all words of a name of two words or more, the same table's first."""
    words = set(re.split(r"[_.]", name.casefold()))
    having = (
        [key for key in schema.rules if words <= set(re.split(r"[_.]", key.casefold()))] if len(words) > 1 else []
    )
    near = [key for key in having if parent(key) == table] or having
    return near if len(near) <= _MOST_MEANINGS else []


def _kinds_with(key: str) -> list[str]:
    """Kinds of gear pair that have such a field."""
    return [kind for kind, schema in SCHEMAS.items() if key in schema.rules]


def _likelihood(table: str, name: str, key: str) -> float:
    if "." in name:  # a path, of which any step may be misspelled
        return closeness(f"{table}.{name}".lstrip("."), key)
    score = closeness(name, last_of(key))
    if score == 0.0:
        return 0.0
    if parent(key) == table:
        return score + _SAME_TABLE_BONUS
    foreign_effect = key.startswith("effects.") and not table.startswith("effects")
    return score - _EFFECT_MALUS if foreign_effect and score < 1.0 else score

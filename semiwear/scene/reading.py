"""Reading of a scene file: every field by its own rule, and unknown names."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from semiwear.errors import Problem
from semiwear.scene.closest import closeness
from semiwear.scene.schema import NEVER_EMPTY, OPTIONAL_TABLES, SCHEMAS, Schema, last_of, parent
from semiwear.scene.values import shown
from semiwear.untyped import Table, Value

# A name from the same table is preferred to an equally close one from another table.
_SAME_TABLE_BONUS = 0.1
# Names of effects are suggested for an unknown name of another table only if no other name is close.
_EFFECT_MALUS = 0.2
_MOST_MEANINGS = 3
_TYPE = "gear_pair.type"
# Symbols and words of drawings, textbooks and other programs, in small letters without underscores or unit, with the
# fields that they denote.
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
# Names of a rating whose inputs a scene does not have, in small letters.
_OF_WORMS = frozenset({"din_3996", "din3996", "iso_14521", "iso_ts_14521", "worm", "worm_wear"})
# Further unknown names are only counted, since the search for the meaning of each takes a millisecond or more.
MOST_UNKNOWN = 20


@dataclass
class Reading:
    """Content of a scene file, field by field.

    Attributes
    ----------
    schema : Schema
        The fields that the scene may have.
    given : dict
        Dotted key to value, for every given field that is within its range.
    refused : set of str
        Dotted keys of the given fields and tables that are wrong.
    tables : set of str
        The tables that are present.
    problems : list of Problem
        Problems found so far.
    """

    schema: Schema
    given: Table = field(default_factory=dict)
    refused: set[str] = field(default_factory=set)
    tables: set[str] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)

    def has(self, key: str) -> bool:
        """Whether the file has a field or table, right or wrong."""
        return key in self.given or key in self.refused or key in self.tables

    def lacks(self, key: str) -> bool:
        """Whether a field is absent although its table is present, or would be by default."""
        return not self.has(key) and self._expects(parent(key))

    @property
    def complete(self) -> bool:
        """Whether every given field is within its range, and every required field is given."""
        return not self.refused and not any(self.lacks(key) for key in self.schema.required)

    def _expects(self, table: str) -> bool:
        if table in self.tables or table in self.refused:
            return table in self.tables
        return table not in OPTIONAL_TABLES and self._expects(parent(table))


def read_fields(data: Mapping[str, Value], schema: Schema, *, kind_is_known: bool = True) -> Reading:
    """Read every field of a nested mapping by its own rule; report wrong values, unknown names and missing fields.

    Parameters
    ----------
    data : mapping
    schema : Schema
    kind_is_known : bool
        Whether the kind of gear pair is certain; else missing fields of the gear pair are not reported.
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
        is_needed = kind_is_known or key == _TYPE or table != parent(_TYPE)
        if is_needed and reading.lacks(key) and f"{table}.data" not in reading.refused:
            fix = _missing_fix(key, schema, kind_is_known)
            reading.problems.append(Problem(key, None, schema.rules[key].allowed, fix))
    return reading


def _missing_fix(key: str, schema: Schema, kind_is_known: bool) -> str:
    table = parent(key)
    if key == _TYPE and not kind_is_known:
        return "give the kind first, its fields depend on it (semiwear fields --kind KIND lists them)"
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
        if value is None:  # a field left out by a caller; TOML has no null
            continue
        key = f"{table}.{name}" if table else str(name)
        # A quoted name that contains a dot must not be read as a path.
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
            f"write the header [{table}]; an effect is active if its table is present, even if empty. "
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
            problem = replace(problem, fix=f"{problem.fix} It is missing.")
        # Read under the suggested name, so that its value is checked, too.
        if meant in schema.tables and isinstance(raw, Mapping):
            _read_table(meant, raw, reading, unknown)
        elif meant in schema.rules:
            _read_value(meant, raw, reading)
    reading.problems.append(problem)


def more_unknown(key: str, count: int) -> Problem:
    """Problem of the unknown names after the first many; `key` is the first of them."""
    return Problem(str(shown(key)), f"{count} more unknown names", "names of a scene", "is this the file of a scene?")


def unknown_key(table: str, name: str, raw: Value, schema: Schema) -> Problem:
    """Problem of an unknown name."""
    key = f"{table}.{name}" if table else name or '""'
    meanings = _meanings(table, name, schema)
    location = f"[{table}]" if table else "the top level"
    allowed = f"a name of {location}"
    if len(meanings) != 1:
        allowed += f": {', '.join(map(last_of, schema.children(table)))}"
    if name.casefold() in _OF_WORMS:
        fix = (
            "remove it: that wear safety is of worm gears, whose inputs a scene does not have (docs/failure_modes.md)"
        )
        return Problem(key, shown(raw), f"a name of {location}", fix)
    if meanings:
        names = (last_of(meant) if parent(meant) == table else meant for meant in meanings)
        fix = f"did you mean {' or '.join(names)}?"
    else:
        others = _kinds_with(key)
        fix = f'remove it: it is of gear_pair.type = "{others[0]}"' if others else "remove it"
    return Problem(key, shown(raw), allowed, fix)


def _meanings(table: str, name: str, schema: Schema) -> list[str]:
    """Dotted keys of the fields and tables that a misspelled or misplaced name may mean; few, or none."""
    symbol = _UNIT.sub("", name.casefold()).replace("_", "")
    keys = (f"{table}.{meant}" for meant in _OTHER_NAMES.get(symbol, ()))
    if known := [key for key in keys if key in schema.rules]:
        return known
    scores = {key: _score(table, name, key) for key in (*schema.rules, *schema.tables) if key}
    best = max(scores.values())
    if best < 1.0 and _kinds_with(f"{table}.{name}"):  # a correct name of another kind of pair
        return []
    if best < 1.0 and (known := _with_the_words(table, name, schema)):
        return known
    closest_keys = [key for key, score in scores.items() if score == best]
    # of several equally close names a required field is preferred
    needed = [key for key in closest_keys if key in schema.required]
    closest_keys = needed if len(needed) == 1 else closest_keys
    return closest_keys if best > 0.0 and len(closest_keys) <= _MOST_MEANINGS else []


def _with_the_words(table: str, name: str, schema: Schema) -> list[str]:
    """Dotted keys of the fields that contain all words of a name of two or more words, preferring the same table."""
    words = set(re.split(r"[_.]", name.casefold()))
    having = (
        [key for key in schema.rules if words <= set(re.split(r"[_.]", key.casefold()))] if len(words) > 1 else []
    )
    preferred = [key for key in having if parent(key) == table] or having
    return preferred if len(preferred) <= _MOST_MEANINGS else []


def _kinds_with(key: str) -> list[str]:
    """Kinds of gear pair that have a field."""
    return [kind for kind, schema in SCHEMAS.items() if key in schema.rules]


def _score(table: str, name: str, key: str) -> float:
    if "." in name:  # a path with a misspelled part
        return closeness(f"{table}.{name}".lstrip("."), key)
    score = closeness(name, last_of(key))
    if score == 0.0:
        return 0.0
    if parent(key) == table:
        return score + _SAME_TABLE_BONUS
    foreign_effect = key.startswith("effects.") and not table.startswith("effects")
    return score - _EFFECT_MALUS if foreign_effect and score < 1.0 else score

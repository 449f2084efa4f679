"""First look at a scene file: every field by itself, and every name."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from semiwear.errors import Problem
from semiwear.scene.closest import closeness
from semiwear.scene.rules import RULES
from semiwear.scene.schema import OPTIONAL_TABLES, REQUIRED, TABLES, children, parent
from semiwear.scene.values import shown

__all__ = ["Reading", "read_fields", "unknown_key"]

# A name from the same table is a likelier meaning than an equally close one from elsewhere.
_SAME_TABLE_BONUS = 0.1


@dataclass
class Reading:
    """What a scene file holds, field by field.

    Attributes
    ----------
    given : dict
        Dotted key to value, for every field that is there and in its range.
    refused : set of str
        Dotted keys of the fields and tables that are there, but wrong.
    tables : set of str
        The tables that are there.
    problems : list of Problem
        What is wrong so far.
    """

    given: dict[str, Any] = field(default_factory=dict)
    refused: set[str] = field(default_factory=set)
    tables: set[str] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)

    def has(self, key: str) -> bool:
        """Whether the file says something, right or wrong, about a field or table."""
        return key in self.given or key in self.refused or key in self.tables

    def lacks(self, key: str) -> bool:
        """Whether a field is absent although the table that holds it is there, or would be by default."""
        return not self.has(key) and self._expects(parent(key))

    def _expects(self, table: str) -> bool:
        if table in self.tables or table in self.refused:
            return table in self.tables
        return table not in OPTIONAL_TABLES and self._expects(parent(table))


def read_fields(data: Mapping[str, Any]) -> Reading:
    """Read every field of a nested mapping by its own rule; report wrong values, unknown names and gaps."""
    reading = Reading()
    unknown: deque[tuple[str, str, Any]] = deque()
    _read_table("", data, reading, unknown)
    while unknown:
        _read_unknown(*unknown.popleft(), reading, unknown)
    for key in sorted(REQUIRED, key=list(RULES).index):
        if reading.lacks(key):
            table = parent(key)
            reading.problems.append(Problem(key, None, RULES[key].allowed, f"needed by [{table}]: add it"))
    return reading


def _read_table(table: str, raw: Any, reading: Reading, unknown: deque[tuple[str, str, Any]]) -> None:
    if not isinstance(raw, Mapping):
        reading.refused.add(table)
        fix = f"write the header [{table}] above its fields"
        reading.problems.append(Problem(table, shown(raw), "a table", fix))
        return
    reading.tables.add(table)
    for name, value in raw.items():
        if value is None:  # TOML has no null: a caller's None stands for a field left out
            continue
        key = f"{table}.{name}" if table else str(name)
        # A quoted name with a dot in it must not pass for a path.
        known = isinstance(name, str) and name != "" and "." not in name
        if known and key in RULES:
            _read_value(key, value, reading)
        elif known and key in TABLES:
            _read_table(key, value, reading, unknown)
        else:
            unknown.append((table, str(name), value))


def _read_value(key: str, raw: Any, reading: Reading) -> None:
    value, problem = RULES[key].apply(key, raw)
    if problem is None:
        reading.given[key] = value
    else:
        reading.refused.add(key)
        reading.problems.append(problem)


def _read_unknown(table: str, name: str, raw: Any, reading: Reading, unknown: deque[tuple[str, str, Any]]) -> None:
    meant = _meaning(table, name)
    problem = unknown_key(table, name, raw, meant)
    if meant is not None and not reading.has(meant):
        if meant in REQUIRED:
            problem = Problem(problem.field, problem.value, problem.allowed, f"{problem.fix} It is missing.")
        # Read on under the name that was meant, so that its value is tested in the same go.
        if meant in TABLES and isinstance(raw, Mapping):
            _read_table(meant, raw, reading, unknown)
        elif meant in RULES:
            _read_value(meant, raw, reading)
    reading.problems.append(problem)


def unknown_key(table: str, name: str, raw: Any, meant: str | None = None) -> Problem:
    """The problem of a name that no table of a scene has."""
    key = f"{table}.{name}" if table else name or '""'
    meant = meant or _meaning(table, name)
    where = f"[{table}]" if table else "the top level"
    allowed = f"a name of {where}"
    if meant is None:
        allowed += f": {', '.join(child.rpartition('.')[2] for child in children(table))}"
    if key.split(".")[0] == "effects":
        fix = "no effects are available yet: remove the table"
    elif meant is None:
        fix = "remove it"
    elif parent(meant) == table:
        fix = f"did you mean {meant.rpartition('.')[2]}?"
    else:
        fix = f"did you mean {meant}?"
    return Problem(key, shown(raw), allowed, fix)


def _meaning(table: str, name: str) -> str | None:
    """Dotted key of the field or table that a misspelled or misplaced name stands for, if that is clear."""
    if (table, name) == ("", "effects"):
        return None
    near, far = children(table), [*RULES, *TABLES]
    scores = {key: closeness(name, key.rpartition(".")[2]) for key in far if key}
    for key in near:
        scores[key] += _SAME_TABLE_BONUS if scores[key] > 0.0 else 0.0
    best = max(scores.values())
    likeliest = [key for key, score in scores.items() if score == best]
    return likeliest[0] if best > 0.0 and len(likeliest) == 1 else None

"""Declaration of a scene's fields, each once: type, default, allowed values and meaning.

Reading, checking and writing a scene, and the documentation of its tables, are derived from it.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from graphlib import TopologicalSorter
from inspect import cleandoc
from typing import TypeVar, dataclass_transform

from semiwear.scene.defaults import DerivedDefault
from semiwear.scene.rule import Rule
from semiwear.untyped import Value

T = TypeVar("T")

_RULE, _MEANING, _DERIVED = "rule", "meaning", "derived"
_WIDTH = 100


def declared(rule: Rule, meaning: str, *, default: Value = MISSING, derived: DerivedDefault | None = None) -> Value:
    """A field of a table.

    Parameters
    ----------
    rule : Rule
        Allowed values, and how they are read.
    meaning : str
        Meaning of the field in a sentence or two, and of a default that is not a plain value.
    default : optional
        Without a default the field is required.
    derived : DerivedDefault, optional
        Default that follows from other fields: None until `filled_in` replaces it.
    """
    if derived is not None:
        default = None
    return field(default=default, metadata={_RULE: rule, _MEANING: meaning, _DERIVED: derived})


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(declared, field))
def table(cls: type[T]) -> type[T]:
    """Class decorator: a frozen dataclass with keyword arguments, whose docstring lists its declared fields."""
    made = dataclass(frozen=True, kw_only=True)(cls)
    made.__doc__ = f"{cleandoc(cls.__doc__ or '')}\n\nAttributes\n----------\n{_attributes(made)}"
    return made


def rules_of(owner: type, name: str) -> Mapping[str, Rule]:
    """Rules of a table's declared fields by dotted key, in the order in which they are declared."""
    prefix = f"{name}." if name else ""
    entries = fields(owner)
    return {prefix + entry.name: entry.metadata[_RULE] for entry in entries if _RULE in entry.metadata}


def meaning_of(owner: type, name: str) -> str:
    """Meaning of a table's declared field, in a sentence; empty if there is none."""
    return next((str(entry.metadata.get(_MEANING, "")) for entry in fields(owner) if entry.name == name), "")


def derived_of(owner: type) -> Mapping[str, DerivedDefault]:
    """Derived defaults of a table's fields, each after those that it needs."""
    entries = fields(owner)
    found = {entry.name: entry.metadata[_DERIVED] for entry in entries if entry.metadata.get(_DERIVED)}
    order = TopologicalSorter({name: [need for need in d.needs if need in found] for name, d in found.items()})
    return {name: found[name] for name in order.static_order()}


def filled_in(table: object) -> frozenset[str]:
    """Fill a table's fields that are None with their derived defaults; returns the names of these fields."""
    defaults = derived_of(type(table))
    derived = [name for name in defaults if getattr(table, name) is None]
    for name in derived:
        default = defaults[name]
        object.__setattr__(table, name, default.formula(*(getattr(table, need) for need in default.needs)))
    return frozenset(derived)


def _attributes(owner: type[Value]) -> str:
    lines = []
    for entry in fields(owner):
        if _RULE not in entry.metadata:
            continue
        sentences = [entry.metadata[_MEANING], f"Allowed: {entry.metadata[_RULE].allowed}."]
        if entry.default is MISSING:
            sentences.append("Required.")
        elif entry.default is not None:
            sentences.append(f"Default {entry.default!r}.")
        lines.append(f"{entry.name} : {entry.type}")
        lines.append(textwrap.indent(textwrap.fill(" ".join(sentences), _WIDTH), "    "))
    return "\n".join(lines)

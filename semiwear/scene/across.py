"""Registration and application of rules over several fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from semiwear.errors import Problem
from semiwear.untyped import Value

CrossRule = Callable[..., Iterator[Problem]]
RuleBook = list[tuple[tuple[str, ...], CrossRule]]
"""Rules, each with the dotted keys of the fields that are its arguments, in order."""


def across(book: RuleBook, table: str, *names: str) -> Callable[[CrossRule], CrossRule]:
    """Decorator that registers a rule; it gets the fields in this order. Dotted names are complete keys."""
    needs = tuple(name if "." in name or not table else f"{table}.{name}" for name in names)

    def register(rule: CrossRule) -> CrossRule:
        book.append((needs, rule))
        return rule

    return register


def find_conflicts(values: Mapping[str, Value], rules: Sequence[tuple[tuple[str, ...], CrossRule]]) -> list[Problem]:
    """Apply every rule whose fields are all known.

    Parameters
    ----------
    values : mapping
        Dotted key to value, defaults included, without fields that are missing or out of range.
    rules : sequence
        Rules in the order in which they are applied.

    Returns
    -------
    list of Problem
        The conflicts. Later rules are not applied to a field found wrong, which avoids follow-on problems.
    """
    valid = dict(values)
    problems: list[Problem] = []
    for needs, rule in rules:
        if not all(key in valid for key in needs):
            continue
        found = list(rule(*(valid[key] for key in needs)))
        problems += found
        for problem in found:
            valid.pop(problem.field, None)
    return problems

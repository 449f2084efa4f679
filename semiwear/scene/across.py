"""How rules over several fields are registered and applied."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from semiwear.errors import Problem
from semiwear.untyped import Value

CrossRule = Callable[..., Iterator[Problem]]
RuleBook = list[tuple[tuple[str, ...], CrossRule]]
"""The dotted keys that a rule takes, in order, and the rule."""


def across(book: RuleBook, table: str, *names: str) -> Callable[[CrossRule], CrossRule]:
    """Register a rule; the fields are passed to it in this order (dotted names stand by themselves)."""
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
        Dotted key to value, defaults included; fields that are missing or out of their own range left out.
    rules : sequence
        Rules in the order in which they are applied.

    Returns
    -------
    list of Problem
        The conflicts. A field found wrong is not believed by later rules, which spares follow-on problems.
    """
    believed = dict(values)
    problems: list[Problem] = []
    for needs, rule in rules:
        if not all(key in believed for key in needs):
            continue
        found = list(rule(*(believed[key] for key in needs)))
        problems += found
        for problem in found:
            believed.pop(problem.field, None)
    return problems

"""Examples in the docstrings of public functions run, and print what they say."""

import doctest
import inspect

import pytest
from site_pages.api import GROUPS

import semiwear as sw
from semiwear import closed_forms, geometry, wear

SLOW = {"optimise"}  # it tries some designs at twice the resolution
FUNCTIONS = [name for name in sw.__all__ if inspect.isfunction(getattr(sw, name))]
FURTHER = [
    *(getattr(package, name) for package in (closed_forms, geometry, wear) for name in package.__all__),
    sw.contact.solve_half_space,
    sw.Scene.replace,
]
SHOWN = [member for member in FURTHER if inspect.isfunction(member) and ">>>" in (member.__doc__ or "")]


def failures(function: object) -> tuple[int, int]:
    """Lines that failed, and lines that were tried."""
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder(recurse=False).find(function, globs={}):
        runner.run(example)
    return runner.failures, runner.tries


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in FUNCTIONS])
def test_examples_of_public_functions_hold(name: str) -> None:
    assert failures(getattr(sw, name))[0] == 0


def test_functions_in_the_groups_of_the_reference_have_examples() -> None:
    grouped = {name for names in GROUPS.values() for name in names} & set(FUNCTIONS)
    assert len(grouped) > 20
    without = {name for name in grouped if ">>>" not in (getattr(sw, name).__doc__ or "")}
    assert without <= {"report"}  # a page with pictures: the first tutorial writes one


@pytest.mark.parametrize("function", SHOWN, ids=lambda one: one.__qualname__)
def test_further_examples_hold(function: object) -> None:
    assert failures(function)[0] == 0


def test_closed_forms_show_how_they_are_called() -> None:
    assert {"effective_modulus", "elliptic_contact", "wear_per_mesh"} <= {one.__name__ for one in SHOWN}

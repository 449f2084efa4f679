"""The list of kernels is written as it is read."""

from __future__ import annotations

from semiwear.kernel_list import kernel_list, lines
from validation.kernel_list import RUNS, name_of, structures_in, type_name


def test_kernels_are_named_as_they_are_listed():
    written = [words for words in lines() if words[0] not in ("structure", "tuple")]
    for words, listed in zip(written, kernel_list(), strict=True):
        assert words[2:] == [name_of(listed.kernel.py_func), *map(type_name, listed.types)]


def test_structures_are_listed_before_what_holds_them():
    parts: dict[str, list[str]] = {}
    for listed in kernel_list():
        for kind in listed.types:
            parts |= structures_in(kind)
    written = {words[1]: words[2:] for words in lines() if words[0] in ("structure", "tuple")}
    assert written == parts
    for number, (name, inside) in enumerate(written.items()):
        assert not set(inside) & set(list(written)[number:]), name


def test_kinds_of_run_are_those_of_the_list():
    assert set(RUNS) == {run for listed in kernel_list() for run in listed.runs}

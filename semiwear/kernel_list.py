"""The list of kernels that first runs compile, `kernel_list.txt`, with the types of their arguments.

numba learns these types when a kernel is called. With the list it is compiled before, in any of several processes.
``python -m validation.kernel_list`` writes the list. A kernel that is not listed, or whose line is out of date, is
compiled when it is called.

A line names a structure or a tuple of arguments, or a kernel::

    structure contact.gap:FreshCurve f8 f8 f8 f8 f8 f8 f8
    tuple (f8[::1],f8) f8[::1] f8
    contact,line,patch,both inner contact.gap:fresh_on contact.gap:FreshCurve f8
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, resources
from inspect import signature
from typing import Literal

from numba import types

from semiwear.untyped import CompilerPart

NUMBERS: dict[str, types.Type] = {"f8": types.float64, "f4": types.float32, "i8": types.int64, "b1": types.boolean}
_ARRAY = re.compile(rf"(const_)?({'|'.join(NUMBERS)})\[((?::,)*)(:|::1)\]")


@dataclass(frozen=True)
class ListedKernel:
    """A kernel that first runs compile.

    Attributes
    ----------
    runs : tuple of str
        Kinds of run that need it.
    called : bool
        Whether Python calls it, not only other kernels.
    kernel : dispatcher of numba
    types : tuple of types.Type
        numba types of its arguments.
    """

    runs: tuple[str, ...]
    called: bool
    kernel: CompilerPart
    types: tuple[types.Type, ...]


def kernel_list(run: str | None = None) -> list[ListedKernel]:
    """The kernels of a kind of run, or all, each after those that it calls.

    Otherwise those come first on which most of the compilation waits. Lines that are out of date are left out.
    """
    parts = {words[1]: words[2:] for words in lines() if words[0] in ("structure", "tuple")}
    found = []
    for words in lines():
        runs = tuple(words[0].split(","))
        if words[0] in ("structure", "tuple") or run not in (None, *runs):
            continue
        try:
            listed = ListedKernel(
                runs, words[1] == "called", named(words[2]), tuple(_type(argument, parts) for argument in words[3:])
            )
        except (AttributeError, ImportError, SyntaxError, ValueError):
            continue
        if len(listed.types) == len(signature(listed.kernel.py_func).parameters):
            found.append(listed)
    return found


@cache
def lines() -> list[list[str]]:
    """Words of the lines of the list."""
    text = resources.files("semiwear").joinpath("kernel_list.txt").read_text(encoding="utf-8")
    return [line.split() for line in text.splitlines()]


def _type(argument: str, parts: Mapping[str, list[str]]) -> CompilerPart:
    if argument in parts:
        structure = () if argument.startswith("(") else (named(argument),)
        inside = [_type(part, parts) for part in parts[argument]]
        if structure and len(inside) != len(structure[0]._fields):
            raise ValueError(argument)
        return types.BaseTuple.from_types(inside, *structure)  # type: ignore[no-untyped-call]
    if array := _ARRAY.fullmatch(argument):
        constant, number, commas, last = array.groups()
        layout: Literal["A", "C"] = "C" if last == "::1" else "A"
        return types.Array(NUMBERS[number], 1 + len(commas) // 2, layout, readonly=bool(constant))
    if argument in NUMBERS:
        return NUMBERS[argument]
    return types.none if argument == "none" else types.literal(ast.literal_eval(argument))  # type: ignore[no-untyped-call]


def named(name: str) -> CompilerPart:
    """The kernel or structure with a name MODULE:NAME in semiwear."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(f"semiwear.{module}"), attribute)

"""Names for values without a type that a checker could know, each with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from numpy.typing import NDArray

Value: TypeAlias = Any
"""A value of a scene or of another TOML file, whose type is checked by the rule of its field when it is read."""

Table: TypeAlias = dict[str, Value]
"""A table of a TOML file, or an object of JSON: values and tables by name."""

Options: TypeAlias = dict[str, Any]
"""Keyword arguments for another library's function, or for a constructor; each value has that argument's type."""

CompilerPart: TypeAlias = Any
"""A part of numba or llvmlite, or a value of the code that they write: neither of them has types."""

Reals: TypeAlias = "NDArray[Any]"
"""Numbers in single or in double precision, depending on an argument at run time."""

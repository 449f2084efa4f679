"""Tables, paragraphs, choices, units and powers of ten as plain text."""

from __future__ import annotations

import csv
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence

_COLUMNS = 118
_LEAST = 24  # columns that the last one of a table has at least
_SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_DECIMAL_POINT = re.compile(r"[+-]?\d*\.\d+([eE][+-]?\d+)?")
_UNITS = {"um": "µm", "1": "", "deg": "°", "degC": "°C"}


def unit_text(units: str) -> str:
    """Units in printed notation."""
    return _UNITS.get(units, re.sub(r"\^(-?\d+)", lambda power: power[1].translate(_SUPERSCRIPT), units))


def power_of_ten(exponent: int) -> str:
    """Ten with a raised exponent."""
    return f"10{str(exponent).translate(_SUPERSCRIPT)}"


def one_of(options: Iterable[str]) -> str:
    """Words to choose from, in quotes."""
    return " or ".join(f'"{option}"' for option in options)


def folded(text: str) -> str:
    """A paragraph, its further lines indented."""
    return textwrap.fill(text, _COLUMNS, subsequent_indent="    ")


def lines_of(text: str) -> list[str]:
    """Lines of a text file that are neither empty nor comments, which begin with #."""
    return [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]


def separator_of(line: str) -> str:
    """Separator of the cells of a table, by its first line: a semicolon, a tab or a comma."""
    return next((mark for mark in ";\t" if mark in line), ",")


def rows_of(text: str) -> list[list[str]]:
    """Cells of a table in a text file, row by row.

    If commas do not separate them, and no number has a point, commas within numbers are decimal ones.

    Raises
    ------
    ValueError
        With the reason why it is no table.
    """
    lines = lines_of(text)
    separator = separator_of(lines[0]) if lines else ","
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
    except csv.Error as error:
        raise ValueError(str(error)) from None
    if separator == "," or any(_DECIMAL_POINT.fullmatch(cell) for row in rows for cell in row):
        return rows
    return [[with_decimal_point(cell) for cell in row] for row in rows]


def with_decimal_point(word: str) -> str:
    """A number with its decimal comma replaced by a point; other words unchanged."""
    return word.replace(",", ".") if _DECIMAL_COMMA.fullmatch(word) else word


def table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """A table, its last column folded."""
    wide = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head) - 1)]
    rule = (*("-" * width for width in wide), "-" * len(head[-1]))
    return "\n".join(_wrapped((head, rule, *rows), wide))


def _wrapped(rows: Iterable[tuple[str, ...]], wide: list[int]) -> Iterator[str]:
    indent = sum(wide) + 2 * len(wide)
    for row in rows:
        left = "  ".join(text.ljust(width) for text, width in zip(row[:-1], wide, strict=True))
        lines = textwrap.wrap(row[-1], max(_COLUMNS - indent, _LEAST)) or [""]
        yield f"{left}  {lines[0]}".rstrip()
        yield from (" " * indent + line for line in lines[1:])

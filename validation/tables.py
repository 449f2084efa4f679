"""Numbers of the report as datasets and as words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
import xarray as xr

from semiwear.plain_text import unit_text
from semiwear.report.markup import element, figure_text

Column = tuple[Any, str, str]
"""Values, units and long name."""


def dataset(
    dims: Mapping[str, Sequence[Any] | np.ndarray], columns: Mapping[str, Column], note: str = ""
) -> xr.Dataset:
    """A dataset whose columns lie over all its dims, or over its first ones.

    Parameters
    ----------
    dims : mapping of str to sequence
        Coordinates.
    columns : mapping of str to (values, units, long name)
    note : str
        Where the numbers come from.
    """
    names = list(dims)
    data = {}
    for name, (values, units, long_name) in columns.items():
        array = np.asarray(values)
        if array.dtype == bool:
            array = array.astype("int8")  # netCDF knows no truth values
        data[name] = (names[: array.ndim], array, {"units": units, "long_name": long_name})
    return xr.Dataset(
        data, {name: np.asarray(values) for name, values in dims.items()}, {"note": note} if note else {}
    )


def percent(share: float, digits: int = 2) -> str:
    """A share as a percentage with so many significant digits."""
    if not np.isfinite(share):
        return "–"
    return f"{figure_text(100.0 * share, digits)} %" if abs(share) >= 1e-6 or share == 0.0 else f"{share:.0e}"


def power(value: float) -> str:
    """A small number in powers of ten."""
    return "–" if not np.isfinite(value) else figure_text(value, 3) if value else "0"


def with_unit(value: float, units: str, digits: int = 4) -> str:
    """A number and its unit."""
    return f"{figure_text(value, digits)} {unit_text(units)}".strip()


def listed(words: Sequence[str]) -> str:
    """Words as a list in a sentence."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else "none"


def failures_note(failures: Sequence[str]) -> str:
    """Runs that could not be made, for all to see; nothing where there are none."""
    lines = "".join(element("li", escape(text)) for text in failures)
    return element("div", f"<p>Not solved:</p><ul>{lines}</ul>", class_="failed") if failures else ""


def text_table(markup: str) -> str:
    """A table whose cells hold text: aligned to the left, and broken into lines."""
    return markup.replace('class="scroll"', 'class="scroll text"', 1)

"""Files that scenes name, as users and disks spoil them: bytes of text and netCDF, and netCDF of another content."""

from collections.abc import Callable

import numpy as np
import xarray as xr
from hypothesis import reject
from hypothesis import strategies as st

_PIECES = ("", ",", ";", "\t", "\n", '"', "#", "nan", "inf", "-1", "1e999", "0,5", "x", " ", "\0", "µ", "um mm mm")


@st.composite
def spoilt_text(draw: st.DrawFn, text: str) -> bytes:
    """A text with up to three pieces exchanged, or in another encoding."""
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(text)))
        piece = draw(st.one_of(st.sampled_from(_PIECES), st.text(max_size=6)))
        text = text[:start] + piece + text[start + draw(st.integers(0, 40)) :]
    return text.encode(draw(st.sampled_from(["utf-8", "utf-8", "utf-8", "utf-16"])), "replace")


@st.composite
def spoilt_binary(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes with some changed, or cut short, behind the first eight, which say what the file is."""
    found = bytearray(content)
    for _ in range(draw(st.integers(0, 4))):
        found[draw(st.integers(8, len(found) - 1))] = draw(st.integers(0, 255))
    return bytes(found[: draw(st.one_of(st.just(len(found)), st.integers(8, len(found))))])


def _of_another_kind(array: xr.DataArray) -> list[Callable[[xr.DataArray], xr.DataArray]]:
    return [
        lambda one: one.astype(str),
        lambda one: one.where(one != one.values.flat[0]),
        lambda one: one * np.inf,
        lambda one: one * 0.0,
        lambda one: -one,
        lambda one: one * 1e300,
        lambda one: one.isel({one.dims[0]: slice(0, 1)}),
        lambda one: one.isel({one.dims[0]: slice(0, 0)}),
        lambda one: one.isel({one.dims[0]: slice(None, None, -1)}),
        lambda one: one.rename({one.dims[0]: "elsewhere"}),
        lambda one: one.isel({one.dims[-1]: 0}),
        lambda one: one.assign_attrs(units="days since yesterday"),
        lambda one: one.assign_attrs(units=3),
    ]


@st.composite
def other_datasets(draw: st.DrawFn, data: xr.Dataset) -> xr.Dataset:
    """A dataset without one of its variables, or with one of another type, size, unit or value."""
    name = draw(st.sampled_from(sorted(map(str, data.variables))))
    if draw(st.booleans()):
        change = draw(st.sampled_from(_of_another_kind(data[name])))
        changed = change(data[name].reset_coords(drop=True))
        rest = data.drop_vars(name)
        shared = {dim for dim in changed.dims if dim in rest.sizes and rest.sizes[dim] != changed.sizes[dim]}
        changed = changed.rename({dim: f"other_{dim}" for dim in shared})
        try:
            return rest.assign({name: (changed.dims, changed.values, changed.attrs)})
        except ValueError:  # a scalar under the name of a dimension
            reject()
    return data.drop_vars(name)

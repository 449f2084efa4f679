"""Names of curves and places beside them, in their colours, where a legend would cover something."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.typing import ColorType

_SIZE = 9.0  # of the letters [points]
_LINE = 1.3  # height of a line of text over the size of its letters
_ALIKE = 0.04  # of the height of the axes: curves that end within it are told apart by their means
_LONG = 16  # letters
_NEAR_BORDER = 0.04  # of the height of the axes: a name beside such a place lies inside it
_DARKER = 0.75  # than its curve: a name has thin strokes


def name_curves(ax: Axes) -> None:
    """Write the name of each labelled curve right of the axes, at the height of its end; limits must stand.

    Names keep clear of one another and stand in the order of the curves' ends, or of their means where all curves end
    together.
    """
    curves = [line for line in ax.get_lines() if not str(line.get_label()).startswith("_")]
    names = [_broken(str(line.get_label())) for line in curves]
    if not curves:
        return
    ax.get_xlim(), ax.get_ylim()  # limits that follow the curves are found when they are asked for
    height = ax.get_window_extent().height * 72.0 / ax.figure.dpi
    room = np.array([(name.count("\n") + 1) * _LINE * _SIZE / height for name in names])
    ends = np.array([_level(ax, line, last=True) for line in curves])
    if len(curves) > 1 and np.ptp(ends) < _ALIKE:
        means = np.array([_level(ax, line, last=False) for line in curves])
        order, wanted = np.argsort(means), ends + 1e-9 * means
        middle = 0.5
        wanted[order] = middle + np.cumsum(room[order]) - 0.5 * room[order] - 0.5 * room.sum()
    else:
        wanted = ends
    for line, name, at in zip(curves, names, _apart(wanted, room), strict=True):
        ax.text(
            1.02, at, name, transform=ax.transAxes, color=_darker(line.get_color()), fontsize=_SIZE, va="center",
            linespacing=1.1,
        )  # fmt: skip


def name_place(
    ax: Axes, x: float, y: float, name: str, *, colour: str = "black", above: bool = False, left: bool | None = None
) -> None:
    """Write the name of a place beside it, rimmed to stand out on any ground; `left` of it or right.

    Unless it is said, towards the middle of the axes: a name at their upper or lower border lies within.
    """
    from matplotlib import patheffects

    if left is None:
        low, high = ax.get_xlim()
        left = x > 0.5 * (low + high)
    low, high = ax.get_ylim()
    share = (y - low) / (high - low)
    beside = "top" if share > 1.0 - _NEAR_BORDER else "bottom" if share < _NEAR_BORDER else "center"
    rim = "black" if colour == "white" else "white"
    ax.annotate(
        name,
        (x, y),
        xytext=(0.0 if above else -7.0 if left else 7.0, 6.0 if above else 0.0),
        textcoords="offset points",
        color=colour,
        fontsize=_SIZE,
        ha="right" if left else "left",
        va="bottom" if above else beside,
        path_effects=[patheffects.withStroke(linewidth=2.2, foreground=rim)],
        zorder=6,
    )


def _broken(name: str) -> str:
    """A name in two lines where it is long."""
    return name.replace(", ", "\n", 1) if len(name) > _LONG else name


def _level(ax: Axes, line: Line2D, *, last: bool) -> float:
    """Height of a curve's end, or its mean height, in the axes."""
    x, y = (np.asarray(values, float) for values in line.get_data())
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return 0.5
    shown = ax.transAxes.inverted().transform(ax.transData.transform(np.column_stack([x[known], y[known]])))[:, 1]
    return float(np.clip(shown[-1] if last else shown.mean(), 0.0, 1.0))


def _apart(wanted: np.ndarray, room: np.ndarray) -> np.ndarray:
    """Heights near the wanted ones whose names do not overlap: pushed up from the lowest, then down from the top."""
    order = np.argsort(wanted, kind="stable")
    at = wanted.astype(float).copy()
    for below, above in pairwise(order):
        at[above] = max(at[above], at[below] + 0.5 * (room[below] + room[above]))
    top = 1.0 + 0.5 * room[order[-1]]
    at[order[-1]] = min(at[order[-1]], top)
    for above, below in pairwise(order[::-1]):
        at[below] = min(at[below], at[above] - 0.5 * (room[below] + room[above]))
    return at


def _darker(colour: ColorType) -> tuple[float, ...]:
    from matplotlib.colors import to_rgb

    return tuple(_DARKER * part for part in to_rgb(colour))

"""Names of curves and points, written beside them in their colours instead of a legend."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.typing import ColorType

_SIZE = 9.0  # of the letters [points]
_LINE = 1.3  # height of a line of text over the size of the letters
_ALIKE = 0.04  # of the height of the axes: curves whose ends differ by less are ordered by their means
_LONG = 16  # letters from which a name has two lines
_NEAR_BORDER = 0.04  # of the height of the axes: names of points so near to a border are put inside
_DARKER = 0.75  # brightness of a name over that of its curve: letters have thin strokes


def name_curves(ax: Axes) -> None:
    """Write the name of each labelled curve right of the axes, at the height of its end; limits must be final.

    Names do not overlap, and have the order of the curves' ends, or of their means if all ends are close together.
    """
    curves = [line for line in ax.get_lines() if not str(line.get_label()).startswith("_")]
    names = [_broken(str(line.get_label())) for line in curves]
    if not curves:
        return
    ax.get_xlim(), ax.get_ylim()  # matplotlib computes automatic limits when they are read
    height = ax.get_window_extent().height * 72.0 / ax.figure.dpi
    heights = np.array([(name.count("\n") + 1) * _LINE * _SIZE / height for name in names])
    levels = np.array([_level(ax, line, last=True) for line in curves])
    if len(curves) > 1 and np.ptp(levels) < _ALIKE:
        order = np.argsort([_level(ax, line, last=False) for line in curves])
        levels[order] = 0.5 + np.cumsum(heights[order]) - 0.5 * heights[order] - 0.5 * heights.sum()
    for line, name, at in zip(curves, names, _apart(levels, heights), strict=True):
        ax.text(
            1.02, at, name, transform=ax.transAxes, color=_darker(line.get_color()), fontsize=_SIZE, va="center",
            linespacing=1.1,
        )  # fmt: skip


def name_place(
    ax: Axes, x: float, y: float, name: str, *, colour: str = "black", above: bool = False, left: bool | None = None
) -> None:
    """Write the name of a point beside it, with a contrasting rim, to its `left` or right.

    By default on the side of the middle of the axes; near their upper or lower border the name is put inside.
    """
    from matplotlib import patheffects

    if left is None:
        low, high = ax.get_xlim()
        left = x > 0.5 * (low + high)
    low, high = ax.get_ylim()
    level = (y - low) / (high - low)
    beside = "top" if level > 1.0 - _NEAR_BORDER else "bottom" if level < _NEAR_BORDER else "center"
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
    """A name, in two lines if it is long."""
    return name.replace(", ", "\n", 1) if len(name) > _LONG else name


def _level(ax: Axes, line: Line2D, *, last: bool) -> float:
    """Height of a curve's end, or its mean height, in the axes."""
    x, y = (np.asarray(values, float) for values in line.get_data())
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return 0.5
    shown = ax.transAxes.inverted().transform(ax.transData.transform(np.column_stack([x[known], y[known]])))[:, 1]
    return float(np.clip(shown[-1] if last else shown.mean(), 0.0, 1.0))


def _apart(levels: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Heights near the `levels` at which names do not overlap: moved up from the lowest, then down from the top."""
    order = np.argsort(levels, kind="stable")
    at = levels.astype(float).copy()
    for below, above in pairwise(order):
        at[above] = max(at[above], at[below] + 0.5 * (heights[below] + heights[above]))
    top = 1.0 + 0.5 * heights[order[-1]]
    at[order[-1]] = min(at[order[-1]], top)
    for above, below in pairwise(order[::-1]):
        at[below] = min(at[below], at[above] - 0.5 * (heights[below] + heights[above]))
    return at


def _darker(colour: ColorType) -> tuple[float, ...]:
    from matplotlib.colors import to_rgb

    return tuple(_DARKER * part for part in to_rgb(colour))

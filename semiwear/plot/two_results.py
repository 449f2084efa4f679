"""Two results of one flank grid: what they are called, and which of their wear steps belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.results.missing import away_from_edges, group_of

_SAME_LIFE = 0.005  # of the meshes or of the wear at the control point, within which two wear steps are one state
_SAME_PLACE = 1e-3  # mm
_GRID = {"face": "numerics.face_slices", "profile": "numerics.profile_points"}


@dataclass(frozen=True)
class TwoResults:
    """Two results, checked to be of the same flank grid.

    Attributes
    ----------
    this, other : DataTree
        Results of `simulate` or `loaded_contact`.
    names : tuple of str
        Their fidelities, or "this" and "other" where these are the same.
    steps : tuple of (int, int)
        Indices of the wear steps that both have: the same meshes or the same wear at the control point, to 0.5 %.
        The first pair is the first wear step of both.
    """

    this: xr.DataTree
    other: xr.DataTree
    names: tuple[str, str]
    steps: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, this: xr.DataTree, other: xr.DataTree) -> TwoResults:
        """Two results side by side.

        Raises
        ------
        SemiwearError
            If their flank grids or flanks differ; the message says in what and what to do.
        """
        _check_same_grid(this, other)
        names = (fidelity(this), fidelity(other))
        return cls(this, other, names if names[0] != names[1] else ("this", "other"), _common_steps(this, other))

    @property
    def trees(self) -> tuple[xr.DataTree, xr.DataTree]:
        """Both results."""
        return self.this, self.other

    def have(self, group: str, name: str) -> bool:
        """Whether both results hold a variable."""
        return all(has(tree, group, name) for tree in self.trees)

    def lack(self, group: str, name: str) -> str:
        """Which of the results does not hold a variable, in words."""
        lacking = [text for text, tree in zip(self.names, self.trees, strict=True) if not has(tree, group, name)]
        return f"no /{group}/{name} in {' and '.join(lacking)}"

    def values(self, group: str, name: str, step: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """A variable of both results at a pair of wear steps; variables without wear steps as they are.

        `contact_pressure_max` away from edges, where others can be compared: NaN where edges alone bear.
        """
        found = []
        for tree, index in zip(self.trees, step, strict=True):
            dataset = tree[group].to_dataset()
            array = away_from_edges(dataset) if name == "contact_pressure_max" else dataset[name]
            found.append(np.asarray(array.isel(wear_step=index) if "wear_step" in array.dims else array, dtype=float))
        return found[0], found[1]

    def labels(self, group: str, dim: str) -> tuple[np.ndarray, np.ndarray]:
        """Coordinate of both results."""
        first, second = (np.asarray(tree[group].to_dataset()[dim].values) for tree in self.trees)
        return first, second

    @property
    def worn(self) -> bool:
        """Whether both hold a worn flank that belongs together."""
        return len(self.steps) > 1 and self.have("flank", "wear_depth")


def has(tree: xr.DataTree, group: str, name: str) -> bool:
    """Whether a result holds a variable or coordinate."""
    return name in group_of(tree, group).variables


def fidelity(tree: xr.DataTree) -> str:
    """Fidelity of a result as its attributes state it."""
    return str(tree.attrs.get("fidelity", "")) or "not stated"


def _check_same_grid(this: xr.DataTree, other: xr.DataTree) -> None:
    sizes = _sizes(this), _sizes(other)
    differing = [dim for dim in _GRID if dim in sizes[0] and dim in sizes[1] and sizes[0][dim] != sizes[1][dim]]
    if differing:
        text = ", ".join(f"{dim} has {sizes[0][dim]} points here and {sizes[1][dim]} there" for dim in differing)
        raise SemiwearError(
            f"the two results lie on different flank grids: {text}; make both with the same "
            f"{' and '.join(_GRID[dim] for dim in differing)}"
        )
    for group, name in (("flank", "face"), ("engagement", "face"), ("flank", "flank_height")):
        if not (has(this, group, name) and has(other, group, name)):
            continue
        places = [np.asarray(tree[group].to_dataset()[name].values, dtype=float) for tree in (this, other)]
        apart = float(np.max(np.abs(places[0] - places[1]), initial=0.0))
        if apart > _SAME_PLACE:
            raise SemiwearError(
                f"the two results are of different flanks: /{group}/{name} differs by up to {apart:.3g} mm; "
                "compare results of the same gear pair and numerics"
            )


def _sizes(tree: xr.DataTree) -> dict[str, int]:
    groups = (group_of(tree, name) for name in ("flank", "engagement"))
    return {str(dim): size for group in groups for dim, size in group.sizes.items() if dim in _GRID}


def _common_steps(this: xr.DataTree, other: xr.DataTree) -> tuple[tuple[int, int], ...]:
    apart = np.full((_count(this), _count(other)), np.inf)
    for name in ("meshes", "wear_depth_control_point"):
        if has(this, "history", name) and has(other, "history", name):
            first, second = (np.asarray(tree["history"].to_dataset()[name].values) for tree in (this, other))
            size = np.maximum(np.abs(first[:, None]), np.abs(second))
            apart = np.minimum(apart, np.abs(first[:, None] - second) / np.where(size > 0.0, size, np.inf))
    apart[0], apart[:, 0] = np.inf, np.inf  # zero of either quantity means unworn, which is no other step
    steps = [(0, 0)]
    for index, row in enumerate(apart):
        nearest = int(np.argmin(row))
        if row[nearest] <= _SAME_LIFE and nearest > steps[-1][1]:
            steps.append((index, nearest))
    return tuple(steps)


def _count(tree: xr.DataTree) -> int:
    """Wear steps of a result."""
    return group_of(tree, "history").sizes.get("wear_step", 1)

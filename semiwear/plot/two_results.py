"""Two results on the same flank grid, with their names and their common wear steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from semiwear.errors import SemiwearError
from semiwear.results.missing import away_from_edges, group_of

_SAME_LIFE = 0.005  # relative difference of meshes or of wear at the control point within which wear steps are common
_SAME_PLACE = 1e-3  # mm
_GRID = {"face": "numerics.face_slices", "profile": "numerics.profile_points"}


@dataclass(frozen=True)
class TwoResults:
    """Two results, checked to have the same flank grid.

    Attributes
    ----------
    this, other : DataTree
        Results of `simulate` or `loaded_contact`.
    names : tuple of str
        Their fidelities, or "this" and "other" where these are the same.
    steps : tuple of (int, int)
        Indices of the common wear steps: those with equal meshes or equal wear at the control point, to 0.5 %. The
        first pair is the first wear step of both.
    """

    this: xr.DataTree
    other: xr.DataTree
    names: tuple[str, str]
    steps: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, this: xr.DataTree, other: xr.DataTree) -> TwoResults:
        """Two results, with names and common wear steps.

        Raises
        ------
        SemiwearError
            If their flank grids or flanks differ; the message names the difference and the remedy.
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

    def missing_text(self, group: str, name: str) -> str:
        """Text that names a variable and the results that do not hold it."""
        without = [text for text, tree in zip(self.names, self.trees, strict=True) if not has(tree, group, name)]
        return f"no /{group}/{name} in {' and '.join(without)}"

    def values(self, group: str, name: str, step: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """A variable of both results at a pair of wear steps; the whole variable if it has no wear steps.

        `contact_pressure_max` is taken away from edges: NaN where only edges carry load.
        """
        found = []
        for tree, index in zip(self.trees, step, strict=True):
            dataset = tree[group].dataset
            array = away_from_edges(dataset) if name == "contact_pressure_max" else dataset[name]
            found.append(np.asarray(array.isel(wear_step=index) if "wear_step" in array.dims else array, dtype=float))
        return found[0], found[1]

    def labels(self, group: str, dim: str) -> tuple[np.ndarray, np.ndarray]:
        """Coordinate of both results."""
        first, second = (np.asarray(tree[group].to_dataset()[dim].values) for tree in self.trees)
        return first, second

    @property
    def worn(self) -> bool:
        """Whether both hold worn flanks at a common wear step."""
        return len(self.steps) > 1 and self.have("flank", "wear_depth")


def has(tree: xr.DataTree, group: str, name: str) -> bool:
    """Whether a result holds a variable or coordinate."""
    return group in tree.children and name in tree[group].variables


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
        difference = float(np.max(np.abs(places[0] - places[1]), initial=0.0))
        if difference > _SAME_PLACE:
            raise SemiwearError(
                f"the two results are of different flanks: /{group}/{name} differs by up to {difference:.3g} mm; "
                "compare results of the same gear pair and numerics"
            )


def _sizes(tree: xr.DataTree) -> dict[str, int]:
    groups = (group_of(tree, name) for name in ("flank", "engagement"))
    return {str(dim): size for group in groups for dim, size in group.sizes.items() if dim in _GRID}


def _common_steps(this: xr.DataTree, other: xr.DataTree) -> tuple[tuple[int, int], ...]:
    difference = np.full((_count(this), _count(other)), np.inf)
    for name in ("meshes", "wear_depth_control_point"):
        if has(this, "history", name) and has(other, "history", name):
            first, second = (np.asarray(tree["history"].to_dataset()[name].values) for tree in (this, other))
            size = np.maximum(np.abs(first[:, None]), np.abs(second))
            relative = np.abs(first[:, None] - second) / np.where(size > 0.0, size, np.inf)
            difference = np.minimum(difference, relative)
    difference[0], difference[:, 0] = np.inf, np.inf  # the unworn state matches no worn one
    steps = [(0, 0)]
    for index, row in enumerate(difference):
        closest = int(np.argmin(row))
        if row[closest] <= _SAME_LIFE and closest > steps[-1][1]:
            steps.append((index, closest))
    return tuple(steps)


def _count(tree: xr.DataTree) -> int:
    """Number of wear steps of a result."""
    return group_of(tree, "history").sizes.get("wear_step", 1)

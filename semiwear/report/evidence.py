"""A result and the published study that it is compared with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from semiwear.results.missing import group_of, why_missing
from semiwear.untyped import Table


class NotComparable(Exception):
    """The result does not hold what a comparison needs; the message names it."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """A result and the reference it is compared with.

    Attributes
    ----------
    tree : DataTree
        A result.
    paper : mapping
        Tables of the reference file.
    scene : mapping
        Tables of the scene.
    """

    tree: xr.DataTree
    paper: Table
    scene: Table

    def get(self, group: str, name: str) -> xr.DataArray:
        """A variable of the result, if the gear pair is that of the paper and there are at least three wear steps."""
        if self.misfit:
            raise NotComparable(f"the pair is not the paper's ({self.misfit})")
        if name not in (variables := group_of(self.tree, group)):
            raise NotComparable(f"the result has no /{group}/{name}")
        array = variables[name]
        if "wear_step" in array.dims and array.sizes["wear_step"] < 3:
            raise NotComparable("the result has fewer than three wear steps")
        return array

    def history(self, name: str, body: str | None = None) -> np.ndarray:
        """History of a quantity: one value per wear step."""
        array = self.get("history", name)
        if why_missing(array):
            raise NotComparable(f"/history/{name} is missing at some wear steps: {why_missing(array)}")
        return np.asarray((array if body is None else array.sel(body=body)).values, dtype=float)

    @cached_property
    def misfit(self) -> str:
        """Fields in which the scene's gear pair differs from the paper's; empty if those of the paper agree."""
        own, paper = self.scene.get("gear_pair", {}), self.paper.get("gear_pair", {})
        return ", ".join(
            f"{name} = {own[name]}, not {paper[name]}" for name in paper if own.get(name, paper[name]) != paper[name]
        )

    @property
    def meshes(self) -> np.ndarray:
        """Meshes of each wear step."""
        return np.asarray(self.get("history", "load_share_max")["meshes"].values, dtype=float)

    @property
    def last_depth(self) -> float:
        """Wear depth at the control point to which the published figures belong [um]."""
        return float(self.paper["wear"]["control_depth_um"][-1])

    def control_depth(self) -> np.ndarray:
        """Wear depth at the control point at each wear step [um], if it reaches the published depth."""
        self._require_worn_gear()
        depth = self.history("wear_depth_control_point")
        if depth[-1] < 0.995 * self.last_depth:
            published = f"the paper's figures are for {self.last_depth:g} µm"
            raise NotComparable(f"the control point wears by {depth[-1]:.3g} µm, {published}")
        return depth

    def at_depth(self, values: np.ndarray, depth: float) -> float:
        """Value when the control point has worn by `depth`."""
        return float(np.interp(depth, self.control_depth(), values))

    def at_last_depth(self, name: str, body: str | None = None) -> float:
        """Value of a history when the control point has reached the paper's last depth."""
        return self.at_depth(self.history(name, body), self.last_depth)

    def until(self, values: np.ndarray, depth: float) -> np.ndarray:
        """Values up to the moment when the control point has worn by `depth`."""
        before = self.control_depth() < depth * (1 - 1e-9)
        return np.append(values[before], self.at_depth(values, depth))

    def gear_flank(self, name: str) -> np.ndarray:
        """A flank variable of the gear over (profile, face), wear at the last step."""
        if name == "wear_depth":
            self._require_worn_gear()
        array = self.get("flank", name).sel(body="gear")
        return np.asarray((array.isel(wear_step=-1) if "wear_step" in array.dims else array).values)

    def _require_worn_gear(self) -> None:
        if "gear" not in self.scene.get("wear", {}).get("worn_bodies", ["gear"]):
            raise NotComparable("in the paper the gear wears, in this result the pinion alone")

    def wear_coefficient(self) -> float:
        """Wear coefficient of the scene [mm^2/N]."""
        value = self.scene.get("wear", {}).get("coefficient_mm2_per_N")
        if not isinstance(value, int | float) or value <= 0:
            raise NotComparable("the scene states no single wear coefficient")
        return float(value)

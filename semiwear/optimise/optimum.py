"""The best design of a search, and all designs that were tried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from semiwear.optimise.designs import COARSE, DOUBLED, OWN, RESOLUTIONS, Aim, Design, Designs
from semiwear.optimise.fine import Found
from semiwear.optimise.quantity import Limit, Quantity
from semiwear.optimise.search import finite_of
from semiwear.results.provenance import version
from semiwear.scene import Scene
from semiwear.scene.values import is_number
from semiwear.untyped import Table, Value

_AT_RESOLUTION = {OWN: "at the resolution of the scene", DOUBLED: "at twice the resolution"}


@dataclass(frozen=True)
class QuantityChange:
    """An aim or limited quantity: of the best design, and of the scene as it was.

    Attributes
    ----------
    quantity : Quantity
    before, best : float
        At the resolution of the scene.
    doubled : float
        Value of the best design at twice the resolution.
    limit : Limit or None
        None for an aim.
    """

    quantity: Quantity
    before: float
    best: float
    doubled: float
    limit: Limit | None = None

    @property
    def error(self) -> float:
        """Relative change of the best design's value with twice the resolution; NaN if unknown."""
        if self.best == self.doubled:  # also if both are infinite, for a life without end
            return 0.0
        change = abs(self.best - self.doubled)
        return change / abs(self.doubled) if self.doubled else change


@dataclass(frozen=True)
class Optimum:
    """Best design of `optimise`.

    Attributes
    ----------
    scene : Scene
        The best design, at the resolution of the scene that was given. With two aims: the design on the front that is
        nearest to the best value of both.
    changes : dict
        Its varied fields.
    aims : tuple of Aim
    told : tuple of QuantityChange
        Aims, then limited quantities.
    kept : bool
        Whether the best design keeps all limits at twice the resolution.
    designs : Dataset
        All designs that were tried, along `sample`: varied fields, quantities, `resolution`, `feasible`, `message`.
    front : Dataset
        For two aims the Pareto front: designs none of which is better than another in both, along `sample`; for one
        aim the best design.
    unsolved : str
        Why the best design could not be solved at the resolution of the scene, or at twice that; empty if it was.
    """

    scene: Scene
    changes: Table
    aims: tuple[Aim, ...]
    told: tuple[QuantityChange, ...]
    kept: bool
    designs: xr.Dataset
    front: xr.Dataset
    unsolved: str = ""

    def __str__(self) -> str:
        width = max(len(key) for key in self.changes)
        lines = ["best design: " + " and ".join(map(str, self.aims)), ""]
        lines += [f"  {key:<{width}}  {_shown(value)}" for key, value in self.changes.items()]
        rows = [("", "before", "best", "error", "limit")]
        for change in self.told:
            quantity = change.quantity
            units = "" if quantity.units == "1" else f" {quantity.units}"
            limit = "" if change.limit is None else change.limit.condition
            values = f"{change.before:.4g}{units}", f"{change.best:.4g}{units}"
            rows.append((quantity.text, *values, _per_cent(change.error), limit))
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        cells = (zip(row, widths, strict=True) for row in rows)
        lines += ["", *("  " + "  ".join(f"{cell:<{w}}" for cell, w in row).rstrip() for row in cells)]
        lines += ["", self.verdict]
        if self.front.sizes["sample"] > 1:
            lines.append(f"{self.front.sizes['sample']} designs on the front, none better than another in both aims")
        return "\n".join(lines)

    @property
    def verdict(self) -> str:
        """One sentence on the limits and the number of designs."""
        tried = {name: int((self.designs["resolution"] == k).sum()) for k, name in enumerate(RESOLUTIONS)}
        count = f"{tried[COARSE]} designs tried on a coarse grid, {tried[OWN]} on that of the scene"
        if self.unsolved:
            return f"{count}; NO design was found that can be solved finely: this one fails {self.unsolved}"
        if not any(change.limit is not None for change in self.told):
            return f"{count}; no limits were given"
        if self.kept:
            return f"{count}; all limits are kept at twice the resolution"
        return (
            f"{count}; NO design was found that keeps all limits at twice the resolution: this one comes nearest; "
            "widen the ranges, or the limits"
        )


def _per_cent(error: float) -> str:
    return "unknown" if np.isnan(error) else f"{error:.1%}"


def _shown(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def optimum_of(designs: Designs, found: list[Found]) -> Optimum:
    """The optimum after searches: one search for one aim, one for every design of the front for two."""
    chosen = _nearest_to_both(designs, found)
    own, doubled = chosen.own, chosen.doubled
    before = designs.of_scene()
    limits: list[Limit | None] = [None] * len(designs.aims) + list(designs.limits)
    values = before.values, own.values, doubled.values
    changes = tuple(
        QuantityChange(quantity, float(was), float(now), float(fine), limit)
        for quantity, was, now, fine, limit in zip(designs.quantities, *values, limits, strict=True)
    )
    unsolved = [f"{_AT_RESOLUTION[end.resolution]} ({end.message})" for end in (own, doubled) if not end.solved]
    return Optimum(
        scene=designs.scene_of(own.point, OWN),
        changes=designs.space.changes(own.point),
        aims=designs.aims,
        told=changes,
        kept=chosen.kept,
        designs=_dataset(designs, designs.tried),
        front=_dataset(designs, [end.own for end in found]),
        unsolved="; ".join(unsolved),
    )


def _nearest_to_both(designs: Designs, found: list[Found]) -> Found:
    """Design whose aims are nearest to the best value of each, relative to their spread on the front."""
    kept = [end for end in found if end.kept and end.own.solved] or found
    if len(kept) == 1 or len(designs.aims) == 1:
        return kept[0]
    values = finite_of(designs.signs * np.stack([end.doubled.aims for end in kept]))
    spread = np.ptp(values, axis=0)
    scaled = (values - values.min(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return kept[int(np.argmin(np.hypot(*scaled.T)))]


def _dataset(designs: Designs, tried: list[Design]) -> xr.Dataset:
    """Designs as a dataset along `sample`."""
    fields = {
        field.name: (
            "sample",
            _labels([field.value(float(design.point[k])) for design in tried]),
            {"field": field.key},
        )
        for k, field in enumerate(designs.space.fields)
    }
    values = np.stack([design.values for design in tried], axis=1)
    names = columns_of(designs.aims, designs.limits)
    quantities = {
        name: _column(quantity, column)
        for name, quantity, column in zip(names, designs.quantities, values, strict=True)
    }
    feasible = np.array([designs.violation(design, designs.bounds) <= 0.0 for design in tried])
    status = {
        "resolution": (
            "sample",
            np.array([RESOLUTIONS.index(design.resolution) for design in tried], dtype=np.int8),
            {"flag_values": np.arange(3, dtype=np.int8), "flag_meanings": " ".join(RESOLUTIONS)},
        ),
        "feasible": ("sample", feasible, {"long_name": "all limits kept"}),
        "message": ("sample", np.array([design.message for design in tried], dtype=np.str_), {}),
    }
    attrs = {
        "title": f"Designs of {designs.scene.title or 'a scene'}",
        "aims": ", ".join(map(str, designs.aims)),
        "limits": ", ".join(map(str, designs.limits)),
        "scene_toml": designs.scene.to_toml(),
        "scene_sha256": designs.scene.sha256,
        "source": f"semiwear {version()}",
    }
    return xr.Dataset({**quantities, **status}, coords=fields, attrs=attrs)


def columns_of(aims: Sequence[Aim], limits: Sequence[Limit]) -> list[str]:
    """Names of aims and then of limited quantities in the dataset of designs.

    Of two bodies or wear states, an upper limit or a minimised aim takes the greater value, a lower limit or a
    maximised aim the lesser. If a quantity occurs in both ways, the name of the later column says which value it is.
    """
    judged = [(aim.quantity.text, aim.minimise) for aim in aims]
    judged += [(limit.quantity.text, limit.at_most) for limit in limits]
    first: dict[str, bool] = {}
    for text, greater in judged:
        first.setdefault(text, greater)
    return [
        text if first[text] == greater else f"{text} ({'greatest' if greater else 'least'})"
        for text, greater in judged
    ]


def _labels(values: list[Value]) -> np.ndarray:
    """Values of a field as an array: numbers if all are numbers, else text."""
    if all(is_number(value) for value in values):
        return np.array(values)
    return np.array(["none" if value is None else str(value) for value in values], dtype=np.str_)


def _column(quantity: Quantity, values: np.ndarray) -> tuple[str, np.ndarray, dict[str, str]]:
    entry = quantity.variable
    return "sample", values, {"units": entry.units, "long_name": entry.long_name, "missing_because": "see message"}

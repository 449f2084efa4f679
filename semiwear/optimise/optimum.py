"""The best design that was found, and the way to it."""

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

_WHERE = {OWN: "at the resolution of the scene", DOUBLED: "at twice the resolution"}


@dataclass(frozen=True)
class Told:
    """A quantity of the best design, and of the scene as it was.

    Attributes
    ----------
    quantity : Quantity
    before, best : float
        At the resolution of the scene.
    doubled : float
        Of the best design at twice the resolution.
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
        """By how much the best design's value changes with twice the resolution, relative; NaN where unknown."""
        if self.best == self.doubled:  # a life without end, too
            return 0.0
        away = abs(self.best - self.doubled)
        return away / abs(self.doubled) if self.doubled else away


@dataclass(frozen=True)
class Optimum:
    """Best design of `optimise`.

    Attributes
    ----------
    scene : Scene
        The best design, at the resolution of the scene that was given. With two aims: the one of the front that is
        nearest to the best of both.
    changes : dict
        Its varied fields.
    aims : tuple of Aim
    told : tuple of Told
        Aims, then limited quantities.
    kept : bool
        Whether it keeps all limits at twice the resolution.
    designs : Dataset
        All designs that were tried, along `sample`: varied fields, quantities, `resolution`, `feasible`, `message`.
    front : Dataset
        The best designs for two aims, none of which is better in both, along `sample`; one design for one aim.
    unsolved : str
        Why the best design could not be solved at the resolution of the scene, or at twice that; empty where it was.
    """

    scene: Scene
    changes: Table
    aims: tuple[Aim, ...]
    told: tuple[Told, ...]
    kept: bool
    designs: xr.Dataset
    front: xr.Dataset
    unsolved: str = ""

    def __str__(self) -> str:
        width = max(len(key) for key in self.changes)
        lines = ["best design: " + " and ".join(map(str, self.aims)), ""]
        lines += [f"  {key:<{width}}  {_shown(value)}" for key, value in self.changes.items()]
        rows = [("", "before", "best", "error", "limit")]
        for one in self.told:
            units = "" if one.quantity.units == "1" else f" {one.quantity.units}"
            limit = "" if one.limit is None else f"{'<=' if one.limit.at_most else '>='} {one.limit.bound:g}"
            rows.append(
                (one.quantity.text, f"{one.before:.4g}{units}", f"{one.best:.4g}{units}", _share(one.error), limit)
            )
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
        if not any(one.limit is not None for one in self.told):
            return f"{count}; no limits were given"
        if self.kept:
            return f"{count}; all limits are kept at twice the resolution"
        return (
            f"{count}; NO design was found that keeps all limits at twice the resolution: this one comes nearest; "
            "widen the ranges, or the limits"
        )


def _share(error: float) -> str:
    return "unknown" if np.isnan(error) else f"{error:.1%}"


def _shown(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def optimum_of(designs: Designs, found: list[Found]) -> Optimum:
    """The optimum after searches: one a design of the front."""
    chosen = _nearest_to_both(designs, found)
    own, doubled = chosen.own, chosen.doubled
    before = designs.of_scene()
    quantities = [aim.quantity for aim in designs.aims] + [limit.quantity for limit in designs.limits]
    limits: list[Limit | None] = [None] * len(designs.aims) + list(designs.limits)
    values = [np.concatenate([one.aims, one.limited]) for one in (before, own, doubled)]
    told = tuple(
        Told(quantity, float(was), float(now), float(fine), limit)
        for quantity, was, now, fine, limit in zip(quantities, *values, limits, strict=True)
    )
    return Optimum(
        scene=designs.scene_of(own.place, OWN),
        changes=designs.space.changes(own.place),
        aims=designs.aims,
        told=told,
        kept=chosen.kept,
        designs=_dataset(designs, designs.tried),
        front=_dataset(designs, [one.own for one in found]),
        unsolved="; ".join(f"{_WHERE[one.resolution]} ({one.message})" for one in (own, doubled) if not one.solved),
    )


def _nearest_to_both(designs: Designs, found: list[Found]) -> Found:
    """The design whose aims are nearest to the best of each, over their spread on the front."""
    kept = [one for one in found if one.kept and one.own.solved] or found
    if len(kept) == 1 or len(designs.aims) == 1:
        return kept[0]
    signs = np.array([1.0 if aim.minimise else -1.0 for aim in designs.aims])
    values = finite_of(signs * np.stack([one.doubled.aims for one in kept]))
    spread = np.ptp(values, axis=0)
    away = (values - values.min(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return kept[int(np.argmin(np.hypot(*away.T)))]


def _dataset(designs: Designs, tried: list[Design]) -> xr.Dataset:
    """Designs as a dataset along `sample`."""
    fields = {
        field.name: (
            "sample",
            _labels([field.value(float(one.place[k])) for one in tried]),
            {"field": field.key},
        )
        for k, field in enumerate(designs.space.fields)
    }
    judged = [aim.quantity for aim in designs.aims] + [limit.quantity for limit in designs.limits]
    values = np.array([[*one.aims, *one.limited] for one in tried]).reshape(len(tried), len(judged))
    names = columns_of(designs.aims, designs.limits)
    quantities = {
        name: _column(quantity, column) for name, quantity, column in zip(names, judged, values.T, strict=True)
    }
    feasible = np.array([designs.violation(one, designs.bounds) <= 0.0 for one in tried])
    own = {
        "resolution": (
            "sample",
            np.array([RESOLUTIONS.index(one.resolution) for one in tried], dtype=np.int8),
            {"flag_values": np.arange(3, dtype=np.int8), "flag_meanings": " ".join(RESOLUTIONS)},
        ),
        "feasible": ("sample", feasible, {"long_name": "all limits kept"}),
        "message": ("sample", np.array([one.message for one in tried], dtype=np.str_), {}),
    }
    attrs = {
        "title": f"Designs of {designs.scene.title or 'a scene'}",
        "aims": ", ".join(map(str, designs.aims)),
        "limits": ", ".join(map(str, designs.limits)),
        "scene_toml": designs.scene.to_toml(),
        "scene_sha256": designs.scene.sha256,
        "source": f"semiwear {version()}",
    }
    return xr.Dataset({**quantities, **own}, coords=fields, attrs=attrs)


def columns_of(aims: Sequence[Aim], limits: Sequence[Limit]) -> list[str]:
    """Names of aims and then of limited quantities in the dataset of designs.

    Of two bodies or wear states an upper limit, or an aim that is to be small, looks at the greater value, a lower
    limit at the less: where one quantity is looked at in both ways the later column says which value it holds.
    """
    looks = [(aim.quantity.text, aim.minimise) for aim in aims]
    looks += [(limit.quantity.text, limit.at_most) for limit in limits]
    first: dict[str, bool] = {}
    for text, greater in looks:
        first.setdefault(text, greater)
    return [
        text if first[text] == greater else f"{text} ({'greatest' if greater else 'least'})"
        for text, greater in looks
    ]


def _labels(values: list[Value]) -> np.ndarray:
    """Numbers, or text."""
    if all(is_number(value) for value in values):
        return np.array(values)
    return np.array(["none" if value is None else str(value) for value in values], dtype=np.str_)


def _column(quantity: Quantity, values: np.ndarray) -> tuple[str, np.ndarray, dict[str, str]]:
    entry = quantity.variable
    return "sample", values, {"units": entry.units, "long_name": entry.long_name, "missing_because": "see message"}

"""Differences of two results as numbers, each marked by a stated threshold."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial

import numpy as np

from semiwear.meshing.flank_pair import BODIES
from semiwear.plain_text import unit_text
from semiwear.plot.flank_regions import Region, flank_regions
from semiwear.plot.two_results import TwoResults
from semiwear.report.markup import with_unit
from semiwear.results.schema import VARIABLES
from semiwear.results.wearing import worn_bodies

RELATIVE = 0.03
"""Greatest relative difference of values that agree: over the greater one; for wear on the map over the greatest."""

LOAD_SHARE = 0.02
"""Greatest difference of load shares that agree."""

_LEAST_LOAD = 0.05  # of the greatest line load: least reference of relative differences of line loads


class Kind(Enum):
    """Kinds of difference; each has its own table and explanation."""

    PRESSURE = "Contact pressure"
    WEAR = "Wear"
    LOAD = "Load sharing"
    ROOT_STRESS = "Root stress"
    TRANSMISSION_ERROR = "Transmission error"


class Mark(Enum):
    """Whether two values agree."""

    AGREE = "agree"
    DIFFER = "differ"
    NOT_COMPARED = "not compared"


@dataclass(frozen=True)
class Difference:
    """One quantity at one place in one wear state, in two results.

    Attributes
    ----------
    kind : Kind
    quantity, where, when : str
        Name of the quantity, place on the flank or in the engagement, and wear state.
    this, other : float
        Values, in `units`.
    units : str
    scale : float
        Reference of a relative difference; 0 for an absolute difference, or if both values are zero.
    threshold : float
        Greatest difference, over `scale` if there is one, at which the two agree.
    scale_text : str
        Name of the scale if it is not the greater value.
    region : Region, optional
        Of a wear difference.
    body : str
        Body whose wear it is; empty for other quantities.
    border : bool
        Whether it lies at a border of the flank.
    missing : str
        Why the values cannot be compared; empty if they can.
    """

    kind: Kind
    quantity: str
    where: str
    when: str
    this: float = 0.0
    other: float = 0.0
    units: str = "1"
    scale: float = 0.0
    threshold: float = RELATIVE
    scale_text: str = ""
    region: Region | None = None
    body: str = ""
    border: bool = False
    missing: str = ""

    @property
    def size(self) -> float:
        """The difference, over the scale if there is one."""
        return (self.this - self.other) / (self.scale or 1.0)

    @property
    def mark(self) -> Mark:
        """Mark that follows from the numbers and the threshold."""
        if self.missing:
            return Mark.NOT_COMPARED
        return Mark.AGREE if abs(self.size) <= self.threshold else Mark.DIFFER

    @property
    def text(self) -> str:
        """The difference as text: in percent, or with its units."""
        if self.missing:
            return self.missing
        if self.scale > 0.0:
            return f"{_signed(100 * self.size, 1)} % {self.scale_text}".strip()
        return f"{_signed(self.size, 3)} {unit_text(self.units)}".strip()

    def value_text(self, value: float) -> str:
        """One of its values with units."""
        return "" if self.missing else with_unit(value, self.units)


def _signed(value: float, decimals: int) -> str:
    """A number with its sign; without one if it rounds to zero."""
    rounded = round(value, decimals) + 0.0
    return f"{rounded:+.{decimals}f}".replace("-", "−") if rounded else f"{0.0:.{decimals}f}"


def differences(results: TwoResults) -> tuple[Difference, ...]:
    """Every difference, in the order of the tables."""
    return (
        *_pressures(results),
        *_wear(results),
        *_loads(results),
        *_root_stresses(results),
        *_transmission_errors(results),
    )


def _states(results: TwoResults) -> dict[str, tuple[int, int]]:
    """Indices of the first and last common wear step, by name."""
    if not results.have("history", "meshes"):
        return {"as given": results.steps[0]}
    return {"unworn": results.steps[0]} | ({"last": results.steps[-1]} if len(results.steps) > 1 else {})


def _in_each_state(
    results: TwoResults,
    kind: Kind,
    quantity: str,
    where: str,
    variable: tuple[str, str],
    reduced: Callable[[np.ndarray], float] = np.nanmax,
    border: bool = False,
) -> Iterator[Difference]:
    """Difference of a number of a variable (group, name), by default its greatest value, in each common state."""
    group, name = variable
    for when, step in _states(results).items():
        if not results.have(group, name):
            yield Difference(kind, quantity, where, when, border=border, missing=results.missing_text(group, name))
            continue
        arrays = results.values(group, name, step)
        without = [label for label, array in zip(results.names, arrays, strict=True) if np.isnan(array).all()]
        if without:
            missing = f"no contact there away from edges in {' and '.join(without)}"
            yield Difference(kind, quantity, where, when, border=border, missing=missing)
            continue
        yield _relative(kind, quantity, where, when, map(reduced, arrays), VARIABLES[variable].units, border=border)


def _relative(
    kind: Kind, quantity: str, where: str, when: str, values: Iterable[float], units: str, border: bool = False
) -> Difference:
    """A difference relative to the greater of the two values."""
    this, other = map(float, values)
    return Difference(kind, quantity, where, when, this, other, units, max(abs(this), abs(other)), border=border)


def _pressures(results: TwoResults) -> Iterator[Difference]:
    kind, quantity = Kind.PRESSURE, "greatest pressure"
    inside, edge = ("engagement", "contact_pressure_max"), ("engagement", "contact_pressure_max_edge")
    yield from _in_each_state(results, kind, quantity, Region.INSIDE.value, inside)
    if results.have("history", "meshes"):
        for zone in ("root", "pitch", "addendum"):
            yield from _in_each_state(results, kind, quantity, zone, ("history", f"contact_pressure_{zone}"))
    yield from _in_each_state(results, kind, quantity, "borders: tips, ends, corners", edge, border=True)


def _wear(results: TwoResults) -> Iterator[Difference]:
    if not results.worn:
        return
    last, when = results.steps[-1], "last"
    for name, quantity, where in (
        ("meshes", "engagements of a gear tooth", "gear"),
        ("wear_depth_control_point", "wear depth", "control point"),
    ):
        if results.have("history", name):
            this, other = (float(value) for value in results.values("history", name, last))
            units = VARIABLES["history", name].units if ("history", name) in VARIABLES else "1"
            yield _relative(Kind.WEAR, quantity, where, when, (this, other), units)
        elif name == "meshes":
            yield Difference(Kind.WEAR, quantity, where, when, missing=results.missing_text("history", name))
    worn = {body for tree in results.trees for body in worn_bodies(tree)} or {"gear"}
    for body in BODIES:
        if body in worn:
            yield from _greatest_wear(results, body, last, when)
    for body in BODIES:
        if body in worn:
            yield from _wear_by_region(results, body, last, when)


def _greatest_wear(results: TwoResults, body: str, last: tuple[int, int], when: str) -> Iterator[Difference]:
    """Greatest wear of a body: on its whole flank if both results hold it, at its root and at its addendum."""
    quantity = f"greatest wear depth, {body}"
    if results.have("history", "wear_depth_max"):
        values = (array[BODIES.index(body)] for array in results.values("history", "wear_depth_max", last))
        yield replace(_relative(Kind.WEAR, quantity, "anywhere", when, values, "um"), body=body)
    for zone in ("root", "addendum"):
        name = f"wear_depth_max_pinion_{zone}" if body == "pinion" else f"wear_depth_max_{zone}"
        if results.have("history", name):
            values = (float(value) for value in results.values("history", name, last))
            yield replace(_relative(Kind.WEAR, quantity, zone, when, values, "um"), body=body)
        else:
            missing = results.missing_text("history", name)
            yield Difference(Kind.WEAR, quantity, zone, when, body=body, missing=missing)


def _wear_by_region(results: TwoResults, body: str, last: tuple[int, int], when: str) -> Iterator[Difference]:
    """Greatest difference of the two wear maps of a body in each region, and the values there."""
    quantity = f"wear depth where it differs most, {body}"
    regions = flank_regions(results, body)
    if regions is None:
        for region in Region:
            missing = "neither result holds the line loads from which the width of the borders follows"
            yield Difference(Kind.WEAR, quantity, region.value, when, region=region, body=body, missing=missing)
        return
    k = BODIES.index(body)
    maps = [array[k] for array in results.values("flank", "wear_depth", last)]
    height, radius = (results.values("flank", f"flank_{name}", last)[0][k] for name in ("height", "radius"))
    scale = max(float(wear.max()) for wear in maps)
    for region, points in regions.points.items():
        border = region is not Region.INSIDE
        row = Difference(Kind.WEAR, quantity, region.value, when, region=region, body=body, border=border)
        if not points.any():
            yield replace(row, missing="no point of the grid lies there")
            continue
        difference = np.where(points, np.abs(maps[0] - maps[1]), -1.0)
        at = np.unravel_index(int(difference.argmax()), difference.shape)
        where = f"{region.value}: radius {radius[at]:.1f}, height {height[at]:+.2f} mm".replace("-", "−")
        this, other = (float(wear[at]) for wear in maps)
        yield replace(row, where=where, this=this, other=other, units="um", scale=scale, scale_text="of the greatest")


def _loads(results: TwoResults) -> Iterator[Difference]:
    kind = Kind.LOAD
    for when, step in _states(results).items():
        if not results.have("engagement", "load_share"):
            missing = results.missing_text("engagement", "load_share")
            yield Difference(kind, "load share where it differs most", "engagement", when, missing=missing)
            continue
        roll, this, other = shares(results, step)
        at = int(np.abs(this - other).argmax())
        where = f"roll position {roll[at]:+.2f}".replace("-", "−")
        pair = float(this[at]), float(other[at])
        yield Difference(kind, "load share where it differs most", where, when, *pair, "1", 0.0, LOAD_SHARE)
    if not results.have("engagement", "line_load"):
        return
    for when, step in _states(results).items():
        greatest = [array.max(axis=0) for array in results.values("engagement", "line_load", step)]
        floor = _LEAST_LOAD * max(float(loads.max()) for loads in greatest)
        for where, part in (("anywhere", np.s_[:]), ("inner face end", np.s_[:1]), ("outer face end", np.s_[-1:])):
            this_load, other_load = (float(loads[part].max()) for loads in greatest)
            scale, border = max(this_load, other_load, floor), where != "anywhere"
            yield Difference(
                kind, "greatest line load", where, when, this_load, other_load, "N/mm", scale, border=border
            )


def shares(results: TwoResults, step: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roll positions of either result in their common range, and the load shares of both there."""
    rolls = results.labels("engagement", "roll_position")
    low, high = max(roll[0] for roll in rolls), min(roll[-1] for roll in rolls)
    roll = np.union1d(*rolls)
    roll = roll[(roll >= low) & (roll <= high)]
    curves = results.values("engagement", "load_share", step)
    this, other = (np.interp(roll, at, curve) for at, curve in zip(rolls, curves, strict=True))
    return roll, this, other


def _root_stresses(results: TwoResults) -> Iterator[Difference]:
    quantity, variable = "greatest root stress", ("engagement", "root_stress")
    for body, name in enumerate(BODIES):
        greatest = partial(_greatest_of, body)
        yield from _in_each_state(results, Kind.ROOT_STRESS, quantity, name, variable, greatest)


def _greatest_of(body: int, stress: np.ndarray) -> float:
    return float(stress[:, body].max())


def _transmission_errors(results: TwoResults) -> Iterator[Difference]:
    kind, variable = Kind.TRANSMISSION_ERROR, ("mesh_cycle", "transmission_error_loaded")
    yield from _in_each_state(results, kind, "mean", "mesh cycle", variable, np.mean)
    yield from _in_each_state(results, kind, "amplitude, peak to peak", "mesh cycle", variable, np.ptp)

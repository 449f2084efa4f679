"""The fast core against finite elements at the shipped scene: python -m validation.finite_elements [--recompute].

Finite elements take a minute a mesh position, so their results are kept in `validation/data`; the core is computed
afresh. Nothing is fitted on either side. Cases:

* `unworn`: one mesh cycle, root stress included;
* `worn`: the same, root stress too, on the flank that the core wears to its last control depth, given to both;
* `moved_nodes`: that flank at the pitch position by nodes really moved;
* `finer`: that flank with twice the elements, which the narrow ridge at the pitch line and pressed tips need;
* `misaligned`, `coast`: one mesh position each;
* `wear_cycle`: some micrometres of wear from the fresh flank, by both.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import fem_reference
import semiwear as sw
from fem_reference.deposit import Deposit, line_pressures, marched
from fem_reference.kinematics import PairKinematics
from fem_reference.line_meshes import usual_element_length
from fem_reference.loaded import mesh_and_solve, torque_of
from fem_reference.mesh_position import MeshSettings
from fem_reference.rigid_lines import RigidFlank
from semiwear.errors import ResultFileError
from semiwear.results import provenance
from semiwear.results.missing import away_from_edges

DATA = Path(__file__).parent / "data"
SCENE = "face_gear_25x160"
POSITIONS = 9
MESHES = 2.5e8
"""Engagements of one gear tooth in the wear cycle: some 6 um."""

LIMITS = {"contact_pressure_max": 0.05, "load_share": 0.03, "transmission_error": 0.05, "root_stress": 0.05}
"""Agreement asked for: relative, load share absolute."""


@dataclass(frozen=True)
class Row:
    """One figure by both.

    Attributes
    ----------
    name : str
    where : str
    core, reference : float
    units : str
    """

    name: str
    where: str
    core: float
    reference: float
    units: str

    @property
    def difference(self) -> float:
        """Core less reference, relative unless the figure is a share."""
        apart = self.core - self.reference
        return apart if self.units == "1" else apart / abs(self.reference) if self.reference else float("nan")


# --- the store ---------------------------------------------------------------------------------------------


def path_of(case: str) -> Path:
    return DATA / f"finite_elements_{case}.nc"


def stored() -> tuple[str, ...]:
    """Cases that can be read."""
    return tuple(case for case in CASES if path_of(case).is_file())


def store(case: str, tree: xr.DataTree, seconds: float) -> Path:
    """Keep a result, with the seconds it took; seven digits of it, which take half the room."""
    DATA.mkdir(exist_ok=True)
    short = tree.map_over_datasets(
        lambda part: part.map(
            lambda x: x.astype("float32").astype(x.dtype) if x.dtype.kind == "f" else x, keep_attrs=True
        )
    )
    short.attrs = tree.attrs | {"seconds": float(seconds)}
    sw.save(short, path_of(case))
    return path_of(case)


def read(case: str, scene: sw.Scene) -> xr.DataTree:
    """A stored result of this very scene.

    Raises
    ------
    FileNotFoundError
        Nothing is stored.
    ResultFileError
        The stored result is of another scene.
    """
    tree = sw.open_results(path_of(case))
    wanted = provenance(title="", scene_toml=scene.to_toml(), physics="", fidelity="", references="")["scene_sha256"]
    if tree.attrs["scene_sha256"] != wanted:
        raise ResultFileError(
            f"{path_of(case)}: computed for another scene (sha256 {tree.attrs['scene_sha256'][:12]}..., this one is "
            f"{wanted[:12]}...); run python -m validation.finite_elements --recompute {case}"
        )
    return tree


# --- what finite elements compute --------------------------------------------------------------------------


@dataclass(frozen=True)
class ContactCase:
    """Loaded contact that both compute.

    Attributes
    ----------
    positions : tuple of float
        Mesh positions.
    worn : bool
        Whether on the flank that the core wears.
    changes : dict
        Fields of the scene.
    placement : Placement, optional
    options : dict
        For `fem_reference.loaded_contact`.
    """

    positions: tuple[float, ...] = tuple(k / POSITIONS for k in range(POSITIONS))
    worn: bool = False
    changes: dict[str, Any] = field(default_factory=dict)
    placement: sw.Placement | None = None
    options: dict[str, Any] = field(default_factory=dict)

    def scene(self, shipped: sw.Scene) -> sw.Scene:
        """The scene with the case's changes."""
        return shipped.replace(self.changes) if self.changes else shipped


_FLAT = {"root_stress": False}
CONTACT = {
    # for loads beside the pinion's fillet, whose root stress is 1.5 to 2.5 % too low in the usual elements
    "unworn": ContactCase(
        options={"element_length": 1.25, "root_elements": {"fillet": 12, "across": 9, "flank": 16}}
    ),
    "worn": ContactCase(worn=True),
    "moved_nodes": ContactCase((0.0,), worn=True, options=_FLAT | {"worn_flank": "moved_nodes"}),
    "finer": ContactCase(worn=True, options={"elements_per_half_width": 6.0}),
    "misaligned": ContactCase((0.3,), placement=sw.Placement(shaft_angle_error_mrad=1.0), options=_FLAT),
    "coast": ContactCase((0.3,), changes={"operation.loaded_flank": "coast"}, options=_FLAT),
}
CASES = (*CONTACT, "wear_cycle")


def compute(case: str, scene: sw.Scene) -> xr.DataTree:
    """A case by finite elements; a worn flank is kept with its result."""
    if case == "wear_cycle":
        # elements as long as slices: with twice that, wear alternates by a tenth from slice to slice
        return fem_reference.simulate(scene, meshes=MESHES, elements_per_half_width=3.0, element_length=1.25)
    one = CONTACT[case]
    if not one.worn:
        return fem_reference.loaded_contact(
            one.scene(scene), one.positions, placement=one.placement, strict=False, **one.options
        )
    flank = worn_flank(scene, anew=case == "worn")
    tree = fem_reference.loaded_contact(scene, one.positions, flank.wear_depth[0], strict=False, **one.options)
    if case == "worn":
        tree["flank"] = xr.DataTree(flank)
    return tree


def recompute(cases: Sequence[str]) -> None:
    """Renew stored results; all cases where none is named."""
    scene = sw.load_scene(SCENE)
    for case in cases or CASES:
        started = time.perf_counter()
        tree = compute(case, scene)
        print(f"{case}: {store(case, tree, time.perf_counter() - started)}", flush=True)


def worn_flank(scene: sw.Scene, *, anew: bool = False) -> xr.Dataset:
    """`/flank` as the core wears it to the last control depth; from the store unless `anew`."""
    if not anew:
        return read("worn", scene)["flank"].to_dataset()
    flank = sw.simulate(scene)["flank"].to_dataset().isel(wear_step=[-1])
    step = flank.wear_step.copy(data=[0])  # the only wear state of a loaded contact
    return flank.assign_coords(wear_step=step)


def march_rows(scene: sw.Scene, *, middle: float = 0.0, every: int = 4, steps: int = 12) -> list[Row]:
    """Wear carried on between mesh positions 1/18 apart, against roll steps of 1/72 summed in place.

    Over one short stretch about a roll position; the points that the contact passes wholly within it count.
    """
    fresh = RigidFlank(PairKinematics(scene), heights=641)
    rolls = middle + (np.arange(steps + 1) - 0.5 * steps) / (18.0 * every)
    settings = MeshSettings(elements_per_half_width=2.0, element_length=usual_element_length(fresh.pair))
    solved = [mesh_and_solve(fresh, float(roll), settings, torque_of(fresh))[1] for roll in rolls]
    pressures = np.stack([line_pressures(result.pairs[0], fresh.pair, fresh) for result in solved])
    summed, whole = marched(fresh, rolls, pressures)
    carried = Deposit.of(fresh, rolls[::every])(pressures[::every])
    unit = 1e3 * scene.wear.coefficient("gear") * MESHES
    where = f"{int(whole.sum())} points"
    apart = unit * float(np.abs(carried - summed)[whole].max())
    return [
        Row("marched: mean wear, carried on / in place", where, unit * carried[whole].mean(),
            unit * summed[whole].mean(), "um"),
        Row("marched: greatest wear", where, unit * carried[whole].max(), unit * summed[whole].max(), "um"),
        Row("marched: greatest difference / wear", where, apart, unit * summed[whole].max(), "um"),
    ]  # fmt: skip


# --- comparisons -------------------------------------------------------------------------------------------


def contact_rows(core: xr.DataTree, reference: xr.DataTree, step: int = 0) -> list[Row]:
    """Every loaded pair and every mesh position of two results of loaded contact."""
    both = [tree["engagement"].to_dataset().isel(wear_step=step) for tree in (core, reference)]
    both = [part.assign(contact_pressure_max=away_from_edges(part)) for part in both]
    # thirds differ in their last digit
    both = [part.assign_coords(roll_position=np.round(part.roll_position.values, 9)) for part in both]
    ours, theirs = xr.align(*both, join="inner")
    rows = []
    for roll in ours.roll_position.values:
        a, b = ours.sel(roll_position=roll), theirs.sel(roll_position=roll)
        if max(float(a.load_share), float(b.load_share)) < 1e-3:
            continue
        where = f"roll {roll:+.3f}"
        rows.append(Row("load_share", where, float(a.load_share), float(b.load_share), "1"))
        pressures = [
            Row(name, where, float(a[name]), float(b[name]), "MPa")
            for name in ("contact_pressure_max", "contact_pressure_max_edge")
        ]
        # beside an edge a pair may have no pressure that is not the edge's
        rows += [row for row in pressures if min(row.core, row.reference) > 0.0]
        for body in ("pinion", "gear") if "root_stress" in b and "root_stress" in a else ():
            values = [float(part.root_stress.sel(body=body)) for part in (a, b)]
            rows.append(Row(f"root_stress {body}", where, values[0], values[1], "MPa"))
    cycles = [
        tree["mesh_cycle"].to_dataset().isel(wear_step=step).sortby("mesh_position") for tree in (core, reference)
    ]
    places = [f"position {place:.3f}" for place in cycles[1].mesh_position.values]
    for name in ("transmission_error_loaded", "transmission_error_unloaded"):
        series = [cycle[name].values for cycle in cycles]
        rows += [Row(name, *row, "arcsec") for row in zip(places, *series, strict=True)]
        rows.append(Row(f"{name}, mean", "cycle", float(series[0].mean()), float(series[1].mean()), "arcsec"))
    return rows


def wear_rows(core: np.ndarray, reference: np.ndarray, label: str = "") -> list[Row]:
    """Greatest wear, its mean, and how alike the maps (profile, face) are."""
    inner = (slice(4, -4), slice(2, -2))
    rows = [
        Row(f"greatest wear{label}", "flank", float(core.max()), float(reference.max()), "um"),
        Row(f"greatest wear{label}", "off borders", float(core[inner].max()), float(reference[inner].max()), "um"),
        Row(f"mean wear{label}", "flank", float(core.mean()), float(reference.mean()), "um"),
    ]
    for where, part in (("flank", (slice(None), slice(None))), ("off borders", inner)):
        alike = float(np.corrcoef(core[part].ravel(), reference[part].ravel())[0, 1])
        rows.append(Row(f"correlation{label}", where, alike, 1.0, "1"))
    return rows


def compare(case: str, scene: sw.Scene, fidelity: str) -> list[Row]:
    """Rows of a stored case, the core computed afresh at a fidelity."""
    at_fidelity = {"numerics.fidelity": fidelity}
    if case == "wear_cycle":
        stored, rows = read(case, scene), []
        theirs = stored["flank"].wear_depth.isel(wear_step=-1).sel(body="gear")
        for steps in (1, 8):
            core = sw.simulate(cycle_scene(scene, MESHES, steps).replace(at_fidelity))
            ours = core["flank"].wear_depth.isel(wear_step=-1).sel(body="gear")
            ours = ours.interp(face=theirs.face, kwargs={"fill_value": "extrapolate"})
            rows += wear_rows(ours.values, theirs.values, f", core in {steps} step(s)")
        return rows
    one = CONTACT[case]
    wear = worn_flank(scene).wear_depth[0] if one.worn else None
    core = sw.loaded_contact(one.scene(scene).replace(at_fidelity), one.positions, wear, one.placement)
    return contact_rows(core, read(case, one.scene(scene)))


def cycle_scene(scene: sw.Scene, meshes: float, steps: int) -> sw.Scene:
    """The scene, worn for some meshes in so many steps."""
    return scene.replace(
        {
            "wear.until.control_depths_um": None,
            "wear.until.meshes": meshes,
            "wear.control_point": None,
            "numerics.wear_steps": steps,
        }
    )


def worst(rows: Sequence[Row]) -> dict[str, Row]:
    """The row of each figure whose difference is greatest."""
    found: dict[str, Row] = {}
    for row in rows:
        if row.name not in found or abs(row.difference) > abs(found[row.name].difference):
            found[row.name] = row
    return found


def table(rows: Sequence[Row]) -> str:
    lines = [f"{'figure':44s} {'where':16s} {'core':>10s} {'elements':>10s} {'apart':>8s}"]
    for row in rows:
        apart = f"{row.difference:+8.4f}" if row.units == "1" else f"{100.0 * row.difference:+7.2f}%"
        lines.append(f"{row.name:44s} {row.where:16s} {row.core:10.4g} {row.reference:10.4g} {apart}")
    return "\n".join(lines)


def main() -> None:
    """Print the comparisons; compute finite elements anew where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recompute", nargs="*", choices=CASES, help="finite elements anew; alone: all cases")
    parser.add_argument("--cases", nargs="*", choices=CASES, help="what is compared; default: all stored")
    parser.add_argument("--fidelity", nargs="*", default=("line", "patch"), help="of the core")
    parser.add_argument("--march", action="store_true", help="also march a short stretch: 13 mesh positions")
    chosen = parser.parse_args()
    scene = sw.load_scene(SCENE)
    if chosen.recompute is not None:
        recompute(chosen.recompute)
    for case in stored() if chosen.cases is None else chosen.cases:
        for fidelity in chosen.fidelity:
            rows = compare(case, scene, fidelity)
            print(f"\n{case}, core at fidelity {fidelity}\n{table(rows)}\ngreatest differences:")
            print(table(list(worst(rows).values())), flush=True)
    if chosen.march:
        print(table(march_rows(scene)))


if __name__ == "__main__":
    main()

"""Ten designs by `sw.optimise`, each beside the best of 2,048 samples of its space.

    python -m validation.optima [--fields]                        the table, from what is stored; or the designs
    python -m validation.optima --search NAME ... [--workers N]   samples anew: ten minutes of processor time each
    python -m validation.optima --optimise NAME ...               the optimiser anew

A search draws scrambled Sobol' points and solves them by `sw.sweep`, which keeps them in a folder, so that a search
that was stopped goes on; problems of one space share its samples. Its best is the first, from the best aim on, that
keeps all limits on the grid of the scene and on one of twice the resolution. Aims are compared on both grids. A
design is within 2 % of the search if its aim is at most 2 % worse on either. Of two aims every sample is solved on
both grids, and every design of the front compared with the search's front: by how much both of its aims have to be
better until no sample is better in both. What counts is the finer grid, on which the optimiser chooses its front; by
how much it is behind on the scene's grid is told beside it.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import xarray as xr
from scipy.stats import qmc

import semiwear as sw
from semiwear.arrays import FloatArray
from semiwear.optimise.designs import DOUBLED, OWN, Design, Designs
from semiwear.optimise.run import plan_search
from semiwear.optimise.space import space_of
from semiwear.sweep.measure import Measured
from semiwear.sweep.outcome import Status
from semiwear.untyped import Table, Value
from validation.charts import pareto

_STORED = Path(__file__).parent / "data" / "optima.json"
SAMPLES = 2048
ALLOWED = 0.02
"""Share of its aim by which a design may be worse than the best sample."""

_SEED = 7
_PINION, _GEAR = "effects.modification.pinion.", "effects.modification.gear."
_SMALL: Table = {
    "numerics.face_slices": 7,
    "numerics.roll_positions": 12,
    "numerics.harmonics": 5,
    "numerics.wear_steps": 1,
    "numerics.profile_points": 61,
}
_SPUR = sw.load_scene("spur_fzg_c").replace({**_SMALL, "wear.until.meshes": 2e7})
_HELICAL = _SPUR.replace(
    {
        "numerics.face_slices": 11,
        "gear_pair.helix_angle_deg": 15.0,
        "gear_pair.centre_distance_mm": None,
        "gear_pair.pinion_face_width_mm": 30.0,
        "operation.pinion_torque_Nm": 500.0,
        "effects.misalignment.pinion_slope_mrad": 0.3,
    }
)
_FACE = sw.load_scene("face_gear_25x160").replace(
    {**_SMALL, "numerics.face_slices": 11, "wear.until.meshes": 3e8, "wear.control_point": None}
)
_RELIEFS = {_PINION + "tip_relief_um": (0, 60), _GEAR + "tip_relief_um": (0, 60)}

Vary = dict[str, tuple[float, float] | list[Value]]

SPACES: dict[str, tuple[sw.Scene, Vary]] = {
    "spur, reliefs": (_SPUR, {**_RELIEFS}),
    "spur, reliefs and lengths": (
        _SPUR,
        {**_RELIEFS, _PINION + "tip_relief_length_mm": (1, 6), _GEAR + "tip_relief_length_mm": (1, 6)},
    ),
    "spur with friction, reliefs and choices": (
        _SPUR.replace({"effects.friction": {}, "operation.pinion_speed_rpm": 2250.0}),
        {
            **_RELIEFS,
            _PINION + "relief_shape": ["parabolic", "linear"],
            "gear_pair.pinion_tip_edge_radius_mm": [0.2, 0.4],
        },
    ),
    "spur, teeth": (
        _SPUR.replace({"gear_pair.centre_distance_mm": None}),
        {
            "gear_pair.pinion_teeth": (15, 18),
            "gear_pair.pinion_profile_shift": [0.0, 0.2, 0.4],
            _GEAR + "tip_relief_um": (0, 60),
        },
    ),
    "leaning helical": (
        _HELICAL,
        {_PINION + "tip_relief_um": (0, 60), _PINION + "crowning_um": (0, 30), _PINION + "lead_slope_um": (-30, 30)},
    ),
    "face gear": (
        _FACE,
        {
            _PINION + "tip_relief_um": (0, 40),
            _PINION + "tip_relief_length_mm": (1, 8),
            _PINION + "crowning_um": (0, 60),
        },
    ),
    "face gear, shaper": (
        _FACE,
        {
            "gear_pair.shaper_teeth": (26, 29),
            _PINION + "tip_relief_um": (0, 40),
            _PINION + "crowning_um": (0, 60),
        },
    ),
}
"""Scenes and what is varied of them."""


@dataclass(frozen=True)
class Case:
    """A problem of the best design.

    Attributes
    ----------
    title : str
    space : str
        Of `SPACES`.
    minimise : tuple of str
        One or two quantities.
    subject_to : dict of str to str
    """

    title: str
    space: str
    minimise: tuple[str, ...]
    subject_to: dict[str, str] = field(default_factory=dict)

    def designs(self, workers: int = 0) -> Designs:
        """What the optimiser knows of the problem before it begins."""
        scene, vary = SPACES[self.space]
        planned = plan_search(scene, vary, self.minimise, subject_to=self.subject_to)
        return Designs(scene, planned.space, planned.aims, planned.limits, workers, lambda design: None)

    def optimise(self, workers: int | None = None) -> sw.Optimum:
        """Its best design, by the optimiser."""
        scene, vary = SPACES[self.space]
        return sw.optimise(scene, vary, minimise=list(self.minimise), subject_to=self.subject_to, workers=workers)


CASES: dict[str, Case] = {
    "spur_wear": Case(
        "spur: least wear within a transmission error", "spur, reliefs", ("wear_depth_max",),
        {"transmission_error_amplitude[worst]": "<= 40"},
    ),
    "spur_front": Case(
        "spur: wear against transmission error", "spur, reliefs",
        ("wear_depth_max", "transmission_error_amplitude[worst]"),
    ),
    "spur_noise": Case(
        "spur: least transmission error within wear and root stress", "spur, reliefs and lengths",
        ("transmission_error_amplitude[unworn]",),
        {"wear_depth_max": "<= 1.6", "root_stress_max[pinion, worst]": "<= 410"},
    ),
    "spur_loss": Case(
        "spur: least friction loss within wear, with choices", "spur with friction, reliefs and choices",
        ("friction_power_loss_mean",), {"wear_depth_max": "<= 1.6"},
    ),
    "spur_teeth": Case(
        "spur: numbers of teeth for the least wear within root stress", "spur, teeth",
        ("wear_depth_max",), {"root_stress_max[pinion, worst]": "<= 400"},
    ),
    "helical_wear": Case(
        "leaning helical: least wear within a transmission error", "leaning helical", ("wear_depth_max",),
        {"transmission_error_amplitude[worst]": "<= 32"},
    ),
    "helical_noise": Case(
        "leaning helical: least transmission error within wear", "leaning helical",
        ("transmission_error_amplitude[unworn]",), {"wear_depth_max": "<= 3"},
    ),
    "face_root_wear": Case(
        "face gear: least root-region wear within load share and transmission error", "face gear",
        ("wear_depth_max_root",),
        {"load_share_max[worst]": "<= 0.97", "transmission_error_amplitude[worst]": "<= 2.8"},
    ),
    "face_stress": Case(
        "face gear: least root stress within root-region wear", "face gear",
        ("root_stress_max[gear, worst]",), {"wear_depth_max_root": "<= 5"},
    ),
    "face_shaper": Case(
        "face gear: teeth of the shaper for the least wear within transmission error", "face gear, shaper",
        ("wear_depth_max",), {"transmission_error_amplitude[worst]": "<= 2.8"},
    ),
}  # fmt: skip


def samples(name: str, folder: Path, workers: int) -> tuple[list[FloatArray], xr.Dataset]:
    """Places of a space, and their sweep."""
    scene, vary = SPACES[name]
    space = space_of(scene, vary)
    places = list(qmc.Sobol(len(space.fields), scramble=True, seed=_SEED).random(SAMPLES))
    changes = [space.changes(place) for place in places]
    table = {key: [one[key] for one in changes] for key in changes[0]}
    store = folder / name.replace(", ", "_").replace(" ", "_")
    return places, sw.sweep(scene, table, combine="zip", workers=workers, store=store)


def _read(designs: Designs, place: FloatArray, sample: xr.Dataset) -> Design:
    """A sample of a sweep as a design on the grid of its scene."""
    if int(sample["status"]) != Status.DONE:
        return Design(place, OWN, np.full(len(designs.aims), np.nan), np.full(len(designs.limits), np.nan))
    known = Measured(
        {one.path: sample[one.variable.name].values for one in designs.quantities}, {"body": sample["body"].values}
    )
    aims = [aim.value(known) for aim in designs.aims]
    limited = [one.quantity.value(known, low_is_good=one.at_most) for one in designs.limits]
    return Design(place, OWN, np.array(aims), np.array(limited))


def searched(case: Case, folder: Path, workers: int) -> Table:
    """Best of the samples of a problem.

    Returns
    -------
    dict
        `samples`, `solved`, `feasible` (on the grid of the scene), and `best` with its `changes`; of two aims
        `front` and `doubled_front`, pairs of them on each grid of which none is better in both.
    """
    places, sweep = samples(case.space, folder, workers)
    designs = case.designs(workers)
    found = [_read(designs, place, sweep.isel(sample=k)) for k, place in enumerate(places)]
    feasible = [one for one in found if designs.violation(one, designs.bounds) <= 0.0]
    told: Table = {
        "samples": len(found),
        "solved": sum(one.solved for one in found),
        "feasible": len(feasible),
        "seconds_a_sample": float(np.nanmean(sweep["seconds"].values)),
    }
    if len(case.minimise) == 2:
        finer = [one for one in designs.solved(places, DOUBLED) if designs.violation(one, designs.bounds) <= 0.0]
        fronts = (front_of(np.stack([one.aims for one in grid])).tolist() for grid in (feasible, finer))
        return {**told, **dict(zip(("front", "doubled_front"), fronts, strict=True))}
    for one in sorted(feasible, key=lambda design: float(design.aims[0])):
        doubled = designs.solved([one.point], DOUBLED)[0]
        if designs.violation(doubled, designs.bounds) <= 0.0:
            best = {"best": float(one.aims[0]), "doubled": float(doubled.aims[0])}
            return {**told, **best, "changes": designs.space.changes(one.point)}
    raise SystemExit(f"{case.title}: no sample keeps the limits at twice the resolution")


def front_of(aims: FloatArray) -> FloatArray:
    """Those of some pairs (n, 2) that no other is better than in both."""
    return aims[pareto(aims[:, 0], aims[:, 1])]


def optimised(case: Case) -> Table:
    """The optimiser's design of a problem.

    Returns
    -------
    dict
        `best` or the `front`, and `changes`; `kept` at twice the resolution, `tried` designs on all grids,
        `processor_seconds` of all processes together, `clock_seconds`.
    """
    clock, processor = time.perf_counter(), _processor_seconds()
    found = case.optimise()
    told: Table = {
        "kept": found.kept,
        "tried": int(found.designs.sizes["sample"]),
        "processor_seconds": _processor_seconds() - processor,
        "clock_seconds": time.perf_counter() - clock,
        "changes": found.changes,
    }
    if len(case.minimise) == 2:
        pairs = np.stack([found.front[name].values for name in case.minimise], axis=1)
        designs = case.designs()
        fields = [found.front[name] for name in found.front.coords]
        rows = [{one.attrs["field"]: one.values[k].item() for one in fields} for k in range(len(pairs))]
        places = [designs.space.start(designs.scene.replace(row)) for row in rows]
        doubled = [one.aims.tolist() for one in designs.solved(places, DOUBLED)]
        return {**told, "front": pairs.tolist(), "doubled_front": doubled}
    return {**told, "best": found.told[0].best, "doubled": found.told[0].doubled}


def _processor_seconds() -> float:
    """Of this process and of those that it has waited for."""
    every = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in every)


def behind(search: Mapping[str, Value], optimum: Mapping[str, Value]) -> float:
    """Share by which the optimiser's aim is worse than that of the search; negative where it is better.

    The greater one of the scene's grid and the finer one. Of a front, on the finer grid, the greatest over its
    designs, and over its ends against the search's best of each aim.
    """
    if "best" in search:
        return max(float(optimum[grid]) / float(search[grid]) - 1.0 for grid in ("best", "doubled"))
    return _front_behind(np.array(search["doubled_front"]), np.array(optimum["doubled_front"]))


def _front_behind(theirs: FloatArray, ours: FloatArray) -> float:
    ends = ours.min(axis=0) / theirs.min(axis=0) - 1.0
    inside = [float((one / theirs - 1.0).min(axis=1).max()) for one in ours]
    return float(max(*ends.tolist(), *inside))


def stored() -> dict[str, Table]:
    """What is stored of each problem: `search` and `optimum`, as these functions return them."""
    return json.loads(_STORED.read_text(encoding="utf-8")) if _STORED.is_file() else {}


def _store(name: str, part: str, told: Table) -> None:
    known = stored()
    known.setdefault(name, {})[part] = told
    ordered = {one: known[one] for one in CASES if one in known}
    _STORED.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")


def report() -> str:
    """The table of what is stored, as text."""
    head = (
        "problem", "kept by", "best sample", "finer", "optimiser", "finer", "worse by", "limits", "tried",
        "processor", "clock",
    )  # fmt: skip
    rows = [head, *(_row(case, stored().get(name, {})) for name, case in CASES.items())]
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    return "\n".join("  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows)


def _row(case: Case, told: Table) -> tuple[str, ...]:
    search, optimum = told.get("search"), told.get("optimum")
    left = ("not searched", "", "") if search is None else (f"{search['feasible']} samples", *_best(search))
    if optimum is None:
        return case.title, *left, "not run", "", "", "", "", "", ""
    worse = "" if search is None else f"{100.0 * behind(search, optimum):+.1f} %"
    if search is not None and "front" in search:
        own = _front_behind(np.array(search["front"]), np.array(optimum["front"]))
        worse += f" ({100.0 * own:+.1f} own)"
    limits = "" if not case.subject_to else "kept" if optimum["kept"] else "NOT kept"
    seconds = [f"{optimum[name]:.0f} s" for name in ("processor_seconds", "clock_seconds")]
    return case.title, *left, *_best(optimum), worse, limits, str(optimum["tried"]), *seconds


def _best(told: Table) -> tuple[str, str]:
    if "front" in told:
        return f"{len(told['front'])} on front", ""
    return f"{told['best']:.4g}", f"{told['doubled']:.4g}"


def designs_found() -> str:
    """Fields of the best sample and of the optimiser's design, of what is stored, as text."""
    lines = []
    for name, told in stored().items():
        one, other = (told.get(part, {}).get("changes", {}) for part in ("search", "optimum"))
        if not one or not other:
            continue
        limits = "; ".join(f"{key} {limit}" for key, limit in CASES[name].subject_to.items())
        lines += [CASES[name].title, f"  least {CASES[name].minimise[0]}; {limits}"]
        lines += [f"  {key}: {_short(one[key])} by samples, {_short(other[key])} by the optimiser" for key in other]
    return "\n".join(lines)


def _short(value: Value) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main(arguments: Sequence[str] | None = None) -> None:
    """Renew what is named, and print the table."""
    parser = argparse.ArgumentParser(prog="python -m validation.optima", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--search", nargs="+", choices=list(CASES), default=[], metavar="NAME")
    parser.add_argument("--optimise", nargs="+", choices=list(CASES), default=[], metavar="NAME")
    parser.add_argument("--workers", type=int, default=2, help="processes of the search")
    parser.add_argument("--samples", type=Path, default=Path("optima-samples"), help="folder of solved samples")
    parser.add_argument("--fields", action="store_true", help="print the designs in place of the table")
    options = parser.parse_args(arguments)
    for name in options.search:
        _store(name, "search", searched(CASES[name], options.samples, options.workers))
        print(f"{name}: searched", flush=True)
    for name in options.optimise:
        _store(name, "optimum", optimised(CASES[name]))
        print(f"{name}: optimised", flush=True)
    print(designs_found() if options.fields else report())


if __name__ == "__main__":
    main()

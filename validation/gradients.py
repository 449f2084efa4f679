"""Are the derivatives that `sensitivities` gives right, do they know when they are not, and what do they cost?

    python -m validation.gradients [--kind face_gear] [--scenes 50] [--fields 20] [--seed 0] [--plain] [--processor]
                                   [--table FOUND.csv]

Pairs of teeth (cylindrical, or a face gear and its pinion), loads, relief and wear are drawn; of each scene the
derivatives of wear depth, pressure, root stress and transmission error with respect to its fields are compared with
Richardson-extrapolated central differences of steps of 4e-5, 8e-5 and 1.6e-4, from smooth runs of their own, or plain
ones, whose differences scatter and take steps of 0.075 to 0.3 %. Of the two that neighbouring steps give, the one
with the smaller error counts (Ridders 1982, Adv. Eng. Software 4, 75-76); longer steps pass over jumps and kinks
which their error does not tell. A derivative should be within 1 % of them, their own error set aside, in 95 % of all;
the rest should be called doubtful.

The cost is the time of the gradient over that of the scene's own run, both as a user calls them, on all cores of the
machine: the run in a process in which all is compiled, which finds its prisms itself, as the gradient finds those of
its other scenes. A second figure takes a second run for the measure, which finds its prisms kept. With `--processor`
it is processor time of one thread.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import semiwear as sw
from semiwear.optimise.quantity import measure_of_quantities, quantity_of
from semiwear.optimise.space import scene_value
from semiwear.plan import Compared
from semiwear.scene import Scene
from semiwear.scene.load import parse_scene
from semiwear.sweep.outcome import Status
from semiwear.sweep.processes import Crew
from semiwear.sweep.scenes import Task
from semiwear.threads import available_threads
from semiwear.untyped import Table

QUANTITIES = (
    "wear_depth_max[gear]",
    "contact_pressure_pitch",
    "root_stress_max[gear]",
    "transmission_error_amplitude",
)
ALLOWED, ASKED = 0.01, 0.95
_MATTERS = 1e-4  # relative change of a quantity over that of a field: less is nothing to an engineer
_STEPS = (4e-5, 8e-5, 1.6e-4)  # of a field's value; not that of `sensitivities`
_PLAIN_STEPS = (7.5e-4, 1.5e-3, 3e-3)  # of it, where runs jump
_QUANTITIES = [one for name in QUANTITIES if (one := quantity_of("of", name, [])) is not None]
_HEAD = "scene,quantity,field,relative,error,reference,reference_error,doubtful"
_MEASURE = measure_of_quantities(_QUANTITIES)

RELIEF = "effects.modification.pinion."
_MATERIAL: dict[str, tuple[float, float]] = {
    "material.pinion.youngs_modulus_MPa": (180e3, 220e3),
    "material.gear.youngs_modulus_MPa": (180e3, 220e3),
    "material.pinion.poissons_ratio": (0.25, 0.33),
    "material.gear.poissons_ratio": (0.25, 0.33),
}
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "cylindrical": {
        "operation.pinion_torque_Nm": (200.0, 400.0),
        "wear.coefficient_mm2_per_N": (0.5e-13, 2e-13),
        "wear.until.meshes": (0.5e8, 2e8),
        **_MATERIAL,
        f"{RELIEF}tip_relief_um": (5.0, 25.0),
        f"{RELIEF}tip_relief_length_mm": (1.0, 2.5),
        f"{RELIEF}root_relief_um": (5.0, 25.0),
        f"{RELIEF}root_relief_length_mm": (1.0, 2.5),
        f"{RELIEF}crowning_um": (3.0, 12.0),
        f"{RELIEF}lead_slope_um": (3.0, 12.0),
        "effects.modification.gear.tip_relief_um": (5.0, 25.0),
        "effects.modification.gear.tip_relief_length_mm": (1.0, 2.5),
        "effects.modification.gear.crowning_um": (3.0, 12.0),
        "effects.misalignment.shaft_angle_error_mrad": (0.1, 1.0),
        "effects.wear_law.load.exponent": (0.7, 1.2),
        "gear_pair.pinion_face_width_mm": (10.0, 18.0),
        "gear_pair.pinion_bore_radius_mm": (12.0, 18.0),
    },
    "face_gear": {
        "operation.pinion_torque_Nm": (1000.0, 2200.0),
        "wear.coefficient_mm2_per_N": (0.5e-13, 2e-13),
        "wear.until.meshes": (0.5e9, 6e9),
        **_MATERIAL,
        f"{RELIEF}tip_relief_um": (5.0, 40.0),
        f"{RELIEF}tip_relief_length_mm": (2.0, 6.0),
        f"{RELIEF}root_relief_um": (5.0, 40.0),
        f"{RELIEF}root_relief_length_mm": (2.0, 6.0),
        f"{RELIEF}crowning_um": (5.0, 40.0),
        f"{RELIEF}lead_slope_um": (5.0, 30.0),
        "effects.misalignment.offset_mm": (0.02, 0.2),
        "effects.misalignment.axial_pinion_mm": (0.02, 0.2),
        "effects.misalignment.axial_gear_mm": (0.02, 0.1),
        "effects.misalignment.shaft_angle_error_mrad": (0.1, 1.0),
        "effects.misalignment.pinion_slope_mrad": (0.1, 0.5),
        "effects.wear_law.load.exponent": (0.7, 1.2),
        "gear_pair.pinion_tip_edge_radius_mm": (0.15, 0.4),
    },
}
"""Fields of the drawn scenes of each kind, and where they lie."""

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 16, "numerics.profile_points": 71}


@dataclass(frozen=True)
class Found:
    """What one scene told.

    Attributes
    ----------
    derivatives, error, reference, reference_error : (quantity, field) arrays
        Relative; `error` is what a derivative says of itself.
    doubtful : (quantity, field) array of bool
    runs : int
    cost, cost_kept : float
        Time over that of the scene's own run, and of one that finds its prisms kept.
    """

    derivatives: np.ndarray
    error: np.ndarray
    reference: np.ndarray
    reference_error: np.ndarray
    doubtful: np.ndarray
    runs: int
    cost: float
    cost_kept: float


def drawn(random: np.random.Generator, kind: str) -> Scene:
    """A scene in the manner of the shipped spur pair, or of the shipped face gear pair."""
    if kind == "face_gear":
        name = "face_gear_25x160"
        teeth: Table = {
            "gear_pair.shaper_teeth": int(random.integers(26, 30)),
            "gear_pair.shaper_tip_radius_mm": 1.0,
            "wear.control_point": None,
        }
    else:
        name = "spur_fzg_c"
        teeth = {
            "gear_pair.pinion_teeth": int(random.integers(16, 25)),
            "gear_pair.gear_teeth": int(random.integers(24, 45)),
            "gear_pair.helix_angle_deg": float(random.choice([0.0, 0.0, 15.0])),
            "gear_pair.centre_distance_mm": None,
        }
    values: Table = {key: float(random.uniform(*ends)) for key, ends in RANGES[kind].items()}
    values["effects.wear_law.load.reference_pressure_MPa"] = 1000.0
    return sw.load_scene(name).replace({**teeth, **values, **COARSE})


def found_for(scene: Scene, fields: Sequence[str], smooth: bool, crew: Crew, processor: bool) -> Found:
    """Derivatives of a scene and their reference, by smooth runs or by those of `semiwear.simulate`."""
    scene = scene.replace({"numerics.threads": 1 if processor else None})
    clock = time.process_time if processor else time.perf_counter
    times = [clock()]
    for _ in range(2):
        sw.simulate(scene)
        times.append(clock())
    told = sw.sensitivities(scene, QUANTITIES, fields, workers=0 if processor else None)
    first, again, whole = np.diff([*times, clock()])
    steps = parse_scene(told.attrs["scene_toml"]).numerics.wear_steps  # of the smooth run
    reference, error = differences(scene.replace({"numerics.wear_steps": steps}), fields, smooth, crew)
    runs = 1 + int(told["runs"].sum())
    own = np.abs(told["error"].values * told["field_value"].values / told["value"].values[:, None])
    slopes, doubtful = told["relative"].values, told["doubtful"].values
    return Found(slopes, own, reference, error, doubtful, runs, whole / first, whole / again)


def differences(scene: Scene, fields: Sequence[str], smooth: bool, crew: Crew) -> tuple[np.ndarray, np.ndarray]:
    """Richardson-extrapolated central differences over the scene's own values, and their error."""
    like = Compared.with_runs_of(scene) if smooth else None
    steps = _STEPS if smooth else _PLAIN_STEPS
    moves = [side * step for step in steps for side in (1, -1)]
    tasks = [Task("", scene, _MEASURE, like)]
    for field in fields:
        at = scene_value(scene, field)
        tasks += [
            Task(f"{field} {move}", scene.replace({field: at * (1.0 + move)}), _MEASURE, like) for move in moves
        ]
    values: dict[str, np.ndarray] = {}
    for outcome in crew.solve(tasks):
        if outcome.status is not Status.DONE:
            raise sw.SemiwearError(outcome.message)
        values[outcome.key] = np.array([one.value(outcome.measured, low_is_good=True) for one in _QUANTITIES])
    central = np.array(
        [
            [(values[f"{field} {step}"] - values[f"{field} {-step}"]) / (2.0 * step) for field in fields]
            for step in steps
        ]
    )
    central = central.swapaxes(1, 2) / values[""][:, None]  # (step, quantity, field)
    near, far = central[:-1], central[1:]
    extrapolated, error = (4.0 * near - far) / 3.0, np.abs(near - far) / 3.0
    best = np.argmin(error, axis=0)[None]
    return np.take_along_axis(extrapolated, best, 0)[0], np.take_along_axis(error, best, 0)[0]


@dataclass
class _Tally:
    """Derivatives of all scenes, counted.

    Attributes
    ----------
    told, right, within : int
        All of them, those within 1 %, and those within their own error.
    doubtful, missed, matter : int
        Of the others: called doubtful, not called so, and of these wrong by more than nothing.
    costs : list of (float, float)
        As in `Found`.
    rows : list of str
        Of the table.
    """

    told: int = 0
    right: int = 0
    within: int = 0
    doubtful: int = 0
    missed: int = 0
    matter: int = 0
    costs: list[tuple[float, float]] = dataclass_field(default_factory=list)
    rows: list[str] = dataclass_field(default_factory=list)

    def add(self, number: int, found: Found, fields: Sequence[str]) -> str:
        """Count a scene; returns a line about it."""
        apart = np.abs(found.derivatives - found.reference)
        good = apart <= ALLOWED * np.abs(found.reference) + found.reference_error
        self.within += int((apart <= found.error + found.reference_error).sum())
        good |= np.maximum(np.abs(found.derivatives), np.abs(found.reference)) <= _MATTERS
        silent = ~good & ~found.doubtful
        self.right, self.told = self.right + int(good.sum()), self.told + good.size
        self.doubtful += int((~good & found.doubtful).sum())
        self.missed += int(silent.sum())
        self.matter += int((silent & (apart > _MATTERS)).sum())
        self.costs.append((found.cost, found.cost_kept))
        told = found.derivatives, found.error, found.reference, found.reference_error, found.doubtful
        for q, name in enumerate(QUANTITIES):
            for k, field in enumerate(fields):
                self.rows.append(f"{number},{name},{field}," + ",".join(f"{one[q, k]:.6g}" for one in told))
        return (
            f"scene {number}: {good.mean():.1%} within 1 %, {silent.sum()} wrong and not told, "
            f"{found.doubtful.mean():.1%} called doubtful, {found.runs} runs, {found.cost:.1f} forward runs of time "
            f"({found.cost_kept:.1f} with prisms kept)"
        )

    @property
    def summary(self) -> str:
        """What all scenes tell."""
        (cost, kept), dearest = np.median(self.costs, axis=0), max(self.costs)[0]
        return (
            f"{len(self.costs)} scenes, {self.told} derivatives: {self.right / self.told:.1%} within 1 %, "
            f"{self.doubtful / self.told:.1%} not and called doubtful, "
            f"{self.missed / self.told:.1%} not and not told, "
            f"{self.matter / self.told:.1%} by more than {_MATTERS:g}; "
            f"{self.within / self.told:.1%} within their own error; "
            f"cost {cost:.1f} forward runs (median; {min(self.costs)[0]:.1f} to {dearest:.1f}; {kept:.1f} with "
            "prisms kept)"
        )

    @property
    def holds(self) -> bool:
        """Whether derivatives are right, or called doubtful, as often as is asked."""
        return self.right >= ASKED * self.told > 0 and self.missed <= (1.0 - ASKED) * self.told


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare derivatives of drawn scenes; 0 where they are right, or called doubtful, as often as is asked."""
    parser = argparse.ArgumentParser(prog="python -m validation.gradients")
    parser.add_argument("--kind", choices=list(RANGES), default="cylindrical", help="of gear pair")
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--fields", type=int, default=20, help="of those that are drawn, the first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--plain", action="store_true", help="reference by runs that are not smooth")
    parser.add_argument("--processor", action="store_true", help="processor time of one thread")
    parser.add_argument("--table", type=Path, help="CSV of every derivative")
    options = parser.parse_args(arguments)
    fields = list(RANGES[options.kind])[: options.fields]
    random = np.random.default_rng(options.seed)
    tally = _Tally()
    with tempfile.TemporaryDirectory() as kept:
        os.environ["SEMIWEAR_CACHE_DIR"] = kept  # no scene finds there what another one kept
        with Crew(available_threads()) as crew:
            # kernels are at hand from here on
            sw.simulate(drawn(np.random.default_rng(options.seed + 1), options.kind))
            for number in range(options.scenes):
                scene = drawn(random, options.kind)
                try:
                    found = found_for(scene, fields, not options.plain, crew, options.processor)
                except (sw.SceneError, sw.SemiwearError) as error:
                    print(f"scene {number}: left out, {str(error).splitlines()[-1]}", flush=True)
                    continue
                print(tally.add(number, found, fields), flush=True)
                if options.table:
                    options.table.write_text("\n".join([_HEAD, *tally.rows]) + "\n", encoding="utf-8")
    if not tally.told:
        return 1
    print(tally.summary)
    return 0 if tally.holds else 1


if __name__ == "__main__":
    sys.exit(main())

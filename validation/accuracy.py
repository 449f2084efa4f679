"""Error found against error asked for, and what it costs, over drawn scenes.

    python -m validation.accuracy [--count N] [--seed N] [--keep FOLDER] [--accuracies A ...]

Scenes are drawn in a moderate neighbourhood of the shipped one (torque, widths, mounting errors, materials, wear
coefficient, depths or meshes to wear to). Each is solved to every accuracy in turn, and once at fixed fine numbers
(`REFERENCE`), which are not exact either: for an accuracy of 0.003 they say little. The error found
is the greatest difference of any quantity in /history, over the greatest value of its kind. Seconds are of the
processor, since a machine has others to serve. References are kept in a folder as netCDF when
one is named.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import ConvergenceError, SceneError
from semiwear.results.kinds import difference, history, worst
from validation.problems import REFERENCE

ACCURACIES = (0.1, 0.03, 0.01, 0.003)


def drawn_scene(random: np.random.Generator) -> sw.Scene:
    """A scene near the shipped one."""
    shipped = sw.load_scene("face_gear_25x160")
    while True:
        depth = float(random.uniform(5.0, 30.0))
        changes: dict[str, Any] = {
            "operation.pinion_torque_Nm": float(np.exp(random.uniform(np.log(400.0), np.log(2500.0)))),
            "gear_pair.pinion_face_width_mm": float(random.uniform(65.0, 80.0)),
            "gear_pair.gear_rim_thickness_mm": float(random.uniform(10.0, 20.0)),
            "material.gear.youngs_modulus_MPa": float(random.choice([110000.0, 170000.0, 207000.0])),
            "wear.coefficient_mm2_per_N": float(10.0 ** random.uniform(-14.0, -12.0)),
            "wear.until.control_depths_um": [0.5 * depth, depth],
            "wear.control_point.height_mm": float(random.choice([-3.0, -2.5, 2.5])),
        }
        if random.random() < 0.5:
            changes["effects.misalignment"] = {
                "offset_mm": float(random.uniform(-0.05, 0.05)),
                "shaft_angle_error_mrad": float(random.uniform(-0.3, 0.3)),
            }
        if random.random() < 0.5:
            torque, k = changes["operation.pinion_torque_Nm"], changes["wear.coefficient_mm2_per_N"]
            changes["wear.until.meshes"] = depth / 60.0 * 1e10 * (1600.0 / torque) * (1e-13 / k)
            del changes["wear.until.control_depths_um"]
        try:
            return shipped.replace(changes)
        except SceneError:
            continue


def reference_of(scene: sw.Scene, keep: Path | None) -> xr.DataTree:
    """The scene at fine numbers, read from `keep` where it is there."""
    fine = scene.replace(REFERENCE)
    path = None if keep is None else keep / f"{fine.sha256[:24]}.nc"
    if path is not None and path.exists():
        return sw.open_results(path)
    from semiwear.simulate import simulate as simulate_as_given  # nothing is to be chosen or estimated

    tree = simulate_as_given(fine)
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        sw.save(tree, path)
    return tree


def solved(scene: sw.Scene, accuracy: float) -> tuple[xr.DataTree, float, bool]:
    """Result, processor seconds, and whether it claims the accuracy."""
    begin = time.process_time()
    try:
        tree, claims = sw.simulate(scene.replace({"numerics.accuracy": accuracy})), True
    except ConvergenceError as error:
        if error.result is None:
            raise
        tree, claims = error.result, False
    return tree, time.process_time() - begin, claims


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and its summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=40, help="combinations of a scene and an accuracy")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES, metavar="A")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where references are kept between runs")
    options = parser.parse_args(arguments)

    random = np.random.default_rng(options.seed)
    rows: list[tuple[float, float, float, float, bool]] = []
    sw.simulate(sw.load_scene("face_gear_25x160").replace({"numerics.face_slices": 11, "numerics.roll_positions": 8}))
    print(" scene   asked    found  estimated  seconds  claimed  worst quantity   numbers", flush=True)
    for index in range(-(-options.count // len(options.accuracies))):
        scene = drawn_scene(random)
        reference = history(reference_of(scene, options.keep))
        for asked in list(options.accuracies)[: options.count - len(rows)]:
            tree, seconds, claims = solved(scene, asked)
            errors = difference(history(tree), reference)
            found, estimate = worst(errors), float(tree["diagnostics"]["error_estimate"].max())
            rows.append((asked, found, estimate, seconds, claims))
            used = {**tree["flank"].sizes, **tree["mesh_cycle"].sizes}
            numbers = ", ".join(f"{name} {used[name]}" for name in ("mesh_position", "face", "profile"))
            name = max(errors, key=lambda key: errors[key])
            told = f"{found:7.4f}  {estimate:9.4f}  {seconds:7.1f}  {'yes' if claims else 'no':>7s}"
            print(f"{index:6d}  {asked:6g}  {told}  {name}: {numbers}", flush=True)
    print(summary(rows))


def summary(rows: Sequence[tuple[float, float, float, float, bool]]) -> str:
    """What the table shows: how often the error asked for is kept, and how time grows."""
    claimed = [row for row in rows if row[4]]
    lines = [f"{len(rows)} combinations, {len(claimed)} of which claim the accuracy asked for"]
    if claimed:
        ratio = np.array([found / asked for asked, found, *_ in claimed])
        kept = 100.0 * float(np.mean(ratio <= 1.0))
        lines.append(f"of these {kept:.0f} % keep it; greatest error over asked {ratio.max():.2f}")
    asked = sorted({row[0] for row in rows}, reverse=True)
    seconds = [float(np.median([row[3] for row in rows if row[0] == one])) for one in asked]
    lines.append("median seconds: " + ", ".join(f"{a:g}: {s:.1f}" for a, s in zip(asked, seconds, strict=True)))
    if len(asked) > 1:
        slope = np.polyfit(np.log(asked), np.log(seconds), 1)[0]
        lines.append(f"time grows as accuracy to the power {slope:.2f}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()

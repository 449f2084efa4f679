"""The fast core against `fem_reference` at the shipped scene: python -m validation.bench_fem [--json FILE] ...

Nothing is fitted on either side. Printed for every tooth pair that carries load: load share, greatest pressure away
from edges, root stress of both bodies; for every mesh position the loaded transmission error. A scene of 1600 N m
takes about a minute a position on two cores with CHOLMOD (scikit-sparse).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from fem_reference.loaded import loaded_contact

LIMITS = {"contact_pressure_max": 0.05, "load_share": 0.03, "transmission_error_loaded": 0.05, "root_stress": 0.05}
"""Agreement asked for: relative, load share absolute."""


def compare(core: xr.DataTree, reference: xr.DataTree) -> dict[str, Any]:
    """Differences of two results, core less reference, and both values."""
    both = [tree["engagement"].to_dataset() for tree in (core, reference)]
    # thirds differ in their last digit
    both = [part.assign_coords(roll_position=np.round(part.roll_position.values, 9)) for part in both]
    ours, theirs = xr.align(*both, join="inner")
    rows = []
    for roll in ours.roll_position.values:
        a, b = (part.isel(wear_step=0).sel(roll_position=roll) for part in (ours, theirs))
        if max(float(a.load_share), float(b.load_share)) <= 0.0:
            continue
        row = {"roll_position": float(roll)}
        for name in ("load_share", "contact_pressure_max", "contact_pressure_max_edge"):
            row |= {f"{name} core": float(a[name]), f"{name} fem": float(b[name])}
        for body in ("pinion", "gear"):
            for label, part in (("core", a), ("fem", b)):
                row[f"root_stress {body} {label}"] = float(part.root_stress.sel(body=body))
        rows.append(row)
    errors = [
        {
            "mesh_position": float(position),
            **{
                f"{name} {label}": float(tree["mesh_cycle"][name].isel(wear_step=0, mesh_position=k))
                for name in ("transmission_error_loaded", "transmission_error_unloaded")
                for label, tree in (("core", core), ("fem", reference))
            },
        }
        for k, position in enumerate(reference["mesh_cycle"].mesh_position.values)
    ]
    return {"pairs": rows, "positions": errors, "worst": worst(rows, errors)}


def worst(rows: list[dict[str, float]], errors: list[dict[str, float]]) -> dict[str, float]:
    """Greatest differences: relative, load share absolute; root stress of the highest stress of each body."""

    def relative(core: float, fem: float) -> float:
        return core / fem - 1.0 if fem > 0.0 else 0.0

    inner = [r for r in rows if min(r["contact_pressure_max core"], r["contact_pressure_max fem"]) > 0.0]
    found = {
        "load_share": max(abs(r["load_share core"] - r["load_share fem"]) for r in rows),
        "contact_pressure_max": max(
            (abs(relative(r["contact_pressure_max core"], r["contact_pressure_max fem"])) for r in inner), default=0.0
        ),
    }
    for body in ("pinion", "gear"):
        peak = {label: max(r[f"root_stress {body} {label}"] for r in rows) for label in ("core", "fem")}
        found[f"root_stress {body}, of the greatest"] = abs(relative(peak["core"], peak["fem"]))
        heavy = [r for r in rows if r["load_share fem"] > 0.3]
        found[f"root_stress {body}, share above 0.3"] = max(
            abs(relative(r[f"root_stress {body} core"], r[f"root_stress {body} fem"])) for r in heavy
        )
    mean = {
        label: float(np.mean([e[f"transmission_error_loaded {label}"] for e in errors])) for label in ("core", "fem")
    }
    found["transmission_error_loaded, mean"] = abs(mean["core"] / mean["fem"] - 1.0)
    return found


def main() -> None:
    """Run the comparison and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    parser.add_argument("--positions", type=int, default=9, help="even mesh positions")
    parser.add_argument("--elements", type=float, default=3.0, help="elements across the half-width")
    parser.add_argument("--length", type=float, default=2.0, help="element length along the line [mm]")
    parser.add_argument("--scene", default="face_gear_25x160")
    parser.add_argument("--fidelity", default="line,patch", help="of the core, separated by commas")
    chosen = parser.parse_args()
    scene = sw.load_scene(chosen.scene)
    positions = np.arange(chosen.positions) / chosen.positions
    started = time.perf_counter()
    reference = loaded_contact(
        scene, positions, elements_per_half_width=chosen.elements, element_length=chosen.length, strict=False
    )
    seconds = time.perf_counter() - started
    stages = {str(s): float(v) for s, v in reference["diagnostics"].seconds.to_series().items()}
    report: dict[str, Any] = {"fem seconds": seconds, "fem stages": stages}
    print(f"finite elements: {seconds:.0f} s for {len(positions)} positions {stages}")
    for fidelity in chosen.fidelity.split(","):
        core = sw.loaded_contact(scene.replace({"numerics.fidelity": fidelity}), positions)
        found = report[fidelity] = compare(core, reference)
        print(f"\n{fidelity}: roll, share, p [MPa], root pinion, root gear [MPa]: core / finite elements")
        for row in found["pairs"]:
            both = [
                f"{row[f'{name} core']:9.{digits}f}/{row[f'{name} fem']:9.{digits}f}"
                for name, digits in (
                    ("load_share", 3),
                    ("contact_pressure_max", 0),
                    ("contact_pressure_max_edge", 0),
                    ("root_stress pinion", 1),
                    ("root_stress gear", 1),
                )
            ]
            print(f"{row['roll_position']:7.3f}", *both)
        for entry in found["positions"]:
            print(
                f"transmission error at {entry['mesh_position']:.3f}: "
                f"{entry['transmission_error_loaded core']:.3f} / {entry['transmission_error_loaded fem']:.3f} arcsec"
            )
        for name, value in found["worst"].items():
            limit = LIMITS[name.split()[0].rstrip(",")]
            print(f"  {name}: {value:.4f} ({'within' if value <= limit else 'BEYOND'} {limit})")
    if chosen.json:
        chosen.json.write_text(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()

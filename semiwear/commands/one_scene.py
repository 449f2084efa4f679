"""Commands on one scene that save no wear run: `screen`, `geometry` and `calibrate`."""

from __future__ import annotations

import argparse
from dataclasses import asdict

import semiwear as sw
from semiwear.commands.progress_bar import ProgressBar
from semiwear.plot.geometry import geometry_figure
from semiwear.targets import file_target, replacing
from semiwear.untyped import Table


def screen(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Print which effects change the results of a scene."""
    with ProgressBar("computing one mesh cycle of the scene as it is ...", "effect", "screening") as bar:
        screening = sw.screen(scene, options.threshold, progress=bar)
    print(screening)
    return {
        "called_for": screening.called_for,
        "could_go": screening.could_go,
        "near_limits": screening.near_limits,
        "base": dict(screening.base),
        "effects": [asdict(row) for row in screening.rows],
    }


def geometry(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Draw a scene's teeth and the path of contact."""
    target = file_target("-o", options.output, (".png", ".svg", ".pdf"))
    figure = geometry_figure(scene)
    with replacing(target) as temporary:
        figure.savefig(temporary, format=target.suffix[1:], dpi=150)
    print(f"teeth: {options.output}")
    return {"teeth": options.output}


def calibrate(options: argparse.Namespace, scene: sw.Scene) -> Table:
    """Print the wear coefficient that fits measured flanks."""
    with ProgressBar(unit="step") as bar:
        calibration = sw.calibrate(
            scene, options.measured, before=options.before, body=options.body, meshes=options.meshes,
            robust=options.robust, confidence=options.confidence, progress=bar,
        )  # fmt: skip
    print(calibration)
    life = None if options.life is None else calibration.life(options.life, k_scatter=options.k_scatter)
    if life is not None:
        print(f"\n{life}")
    return {
        "body": calibration.body,
        "coefficient_mm2_per_N": calibration.coefficient,
        "coefficients_mm2_per_N": calibration.coefficients,
        "interval_mm2_per_N": calibration.interval,
        "confidence": calibration.confidence,
        "life": None if life is None else str(life),
    }

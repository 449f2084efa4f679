"""The seed paper: every statement and figure, the torque behind them, and what its wear steps explain."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.references import load_reference
from semiwear.report.comparison import Compared, Verdict, compare
from semiwear.report.markup import figure_text, table
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.sections.paper_steps import (
    QUICK_STEPS,
    STEPS,
    explained,
    life_of,
    life_part,
    schemes_part,
    worn_by_schemes,
)
from validation.sections.paper_torque import (
    FIGURES,
    QUICK,
    QUICK_TORQUES,
    SETS,
    TOLERANCE,
    TORQUES,
    model_of,
    over_torque,
    torque_part,
)
from validation.tables import dataset, percent, text_table, with_unit
from validation.torque_inference import BestTorque, Inferred, best_torque, inferred_torque

TITLE = "The paper"


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Compare the shipped scene with the paper."""
    paper = load_reference("seed_paper")
    scene = sw.load_scene("face_gear_25x160")
    progress.note("the shipped scene")
    tree = sw.simulate(scene)
    comparison = compare("seed_paper", tree, tomllib.loads(scene.to_toml()))
    compared = comparison.statements

    coarse = scene.replace(QUICK) if quick else scene
    values, kept = over_torque(coarse, QUICK_TORQUES if quick else TORQUES, progress)
    printed = {name: float(paper["at_60_um"][key]) for name, (key, _) in FIGURES.items()}
    inferred = [
        inferred_torque(name, printed[name], kept, values[name], None if quick else model_of(coarse, name, progress))
        for name in FIGURES
    ]
    best = {
        title: best_torque({name: printed[name] for name in names}, kept, values, TOLERANCE)
        for title, names in SETS.items()
    }
    schemes = worn_by_schemes(scene, (31,) if quick else (31, 61, 91), QUICK_STEPS if quick else STEPS, progress)
    life = life_of(tree, paper)
    html = (
        f"<p>“{comparison.title}”. The paper states neither torque nor materials, heights or fillets; the shipped "
        "scene has usual ones. Verdicts are computed by the rule beside each statement.</p>"
        + _statements(compared)
        + torque_part(inferred, best, kept, values, printed)
        + _radii(scene, paper)
        + life_part(life)
        + schemes_part(schemes, paper)
    )
    data = {
        "statements": dataset(
            {"statement": np.arange(len(compared))},
            {
                "paper": ([one.statement for one in compared], "1", "what the paper says"),
                "ours": ([one.ours for one in compared], "1", "what is found here"),
                "rule": ([one.rule for one in compared], "1", "when the two agree"),
                "verdict": ([one.verdict.value for one in compared], "1", "verdict"),
            },
        ),
        "torque": dataset(
            {"torque_Nm": np.array(kept)},
            {name.replace(" ", "_"): (values[name], unit, name) for name, (_, unit) in FIGURES.items()},
            "after 60 um at the control point",
        ),
        "life": life,
        "schemes": schemes,
    }
    return Section(_found(compared, best, inferred, life, schemes, paper), html, data)


# ---- statements


def _found(
    compared: Sequence[Compared],
    best: Mapping[str, BestTorque],
    inferred: Sequence[Inferred],
    life: xr.Dataset,
    schemes: xr.Dataset,
    paper: Mapping[str, Any],
) -> tuple[str, ...]:
    agree = sum(one.verdict is Verdict.AGREE for one in compared)
    whole = best["root stress and transmission error as printed"]
    without = best["the same with the rigid part of wear taken out"]
    fitting = [title for title, one in best.items() if one.fits]
    none = [one.name for one in inferred if not one.torques]
    band = f"within {100 * TOLERANCE:g} %"
    if whole.fits:
        torque = f"One torque, {with_unit(whole.torque, 'N m', 3)}, fits root stress and transmission error {band}"
    else:
        torque = (
            f"No torque fits the printed root stress and transmission error {band}: the best of those searched, "
            f"{with_unit(whole.torque, 'N m', 3)}, misses the {whole.figure} by {percent(whole.worst)}"
        )
    how = "fits them" if without.fits else "misses one"
    torque += (
        f"; without the rigid part of wear the best, {with_unit(without.torque, 'N m', 3)}, {how} by "
        f"{percent(without.worst)}"
    )
    torque += f". No torque at all gives the printed {'; '.join(none)}" if none else ""
    torque += (
        f". What one torque fits: {'; '.join(fitting)}." if fitting else ". No pair of figures is fitted either."
    )
    worst = explained(schemes, paper)
    return (
        f"{agree} of {len(compared)} statements of the paper agree with the shipped scene.",
        torque,
        f"The paper's wear coefficient times engagements is {figure_text(float(life.factor[-1]), 3)} times what its "
        f"wear needs here. {worst}",
    )


def _statements(compared: Sequence[Compared]) -> str:
    boxes = "".join(_statement(one) for one in compared)
    return f'<h3>Statement by statement</h3><div class="statements">{boxes}</div>'


def _statement(one: Compared) -> str:
    parts = {"Paper": one.statement, "Here": one.ours, "Why": one.why, "Rule": one.rule}
    lines = "".join(f"<dt>{name}</dt><dd>{escape(text)}</dd>" for name, text in parts.items() if text)
    verdict = one.verdict.value
    kind = verdict.lower().replace(" ", "-")
    return f'<div class="comparison {kind}"><p class="verdict">{verdict}</p><dl>{lines}</dl></div>'


# ---- radii


def _radii(scene: sw.Scene, paper: Mapping[str, Any]) -> str:
    pair = paper["gear_pair"]
    contact = sw.tooth_contact_analysis(scene.replace({"wear": None}))
    pitch = 0.5 * pair["module_mm"] * pair["gear_teeth"]
    inner, outer = pair["gear_inner_radius_mm"], pair["gear_outer_radius_mm"]
    try:
        scene.replace({"gear_pair.gear_inner_radius_mm": inner / 2, "gear_pair.gear_outer_radius_mm": outer / 2})
        refused = "A scene with half of them is accepted."
    except SceneError as error:
        refused = f"Read as diameters, the scene is refused: {error.problems[0]}"
    holds = inner < pitch < outer and outer - inner == pair["gear_face_width_mm"]
    undercut, pointing = float(contact["undercut_radius"]), float(contact["pointing_radius"])
    rows = [
        ("pitch radius, module times teeth / 2", with_unit(pitch, "mm", 5)),
        ("printed as inner and outer diameter", f"{inner:g} and {outer:g} mm"),
        ("their difference, and the printed face width", f"{outer - inner:g} and {pair['gear_face_width_mm']:g} mm"),
        ("undercut ends at radius", with_unit(undercut, "mm", 5)),
        ("teeth point at radius", with_unit(pointing, "mm", 5)),
        ("as radii, they hold the pitch radius, the face width and both limits",
         "yes" if holds and undercut < inner and outer < pointing else "no"),
        ("as diameters", refused),
    ]  # fmt: skip
    text = "<h3>Mislabelled radii</h3>"
    return text + text_table(table("What the paper prints as diameters", ("quantity", "value"), rows))

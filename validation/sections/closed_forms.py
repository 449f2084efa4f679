"""Closed forms and literature: Hertz, the swept-line identity, a published wear test, spur gears by the standards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.closed_forms.hertz import elliptic_contact
from semiwear.contact import solve_half_space
from semiwear.plan import plan
from semiwear.report.markup import figure_text, table
from semiwear.wear.archard import wear_per_mesh
from semiwear.wear.swept_line import wear_of_mesh, worn_sweep
from validation.charts import COLOURS, MARKERS, card, cards, legend_above, plain_log
from validation.iso_spur import IsoRow, iso_rows
from validation.problems import BlockOnRing, Problems
from validation.progress import Progress
from validation.section import Section
from validation.sections.block_on_ring import (
    RING_STEPS,
    RING_STRIPS,
    RingRun,
    against_tests,
    depths_data,
    profile_data,
    ring_part,
    ring_run,
)
from validation.tables import dataset, percent, with_unit

TITLE = "Closed forms and literature"
LOAD, CURVATURES, MODULUS = 5000.0, (1 / 20.0, 1 / 2000.0), 115e3  # of the elliptic contact: N, 1/mm, MPa
_SIZES = (32, 48, 64, 96, 128)


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Compare contact and wear with closed forms and with published tests."""
    progress.note("Hertz")
    hertz = _hertz(_SIZES if quick else (*_SIZES, 192, 256, 384, 512))
    progress.note("swept-line identity")
    swept = _swept(quick)
    progress.note("block on ring")
    runs = {steps: ring_run(problems.block_on_ring, RING_STRIPS, steps) for steps in RING_STEPS}
    progress.note("spur gears")
    iso = iso_rows(sw.load_scene("spur_fzg_c").replace({"numerics.face_slices": 21} if quick else {}))
    html = _hertz_html(hertz) + _swept_html(swept) + ring_part(problems.block_on_ring, runs) + _iso_html(iso)
    data = {
        "hertz": hertz,
        "swept_line": swept,
        "block_on_ring": depths_data(problems.block_on_ring, runs),
        "block_on_ring_profile": profile_data(problems.block_on_ring, runs[max(runs)]),
        "spur": dataset(
            {"quantity": [row.name for row in iso]},
            {
                "closed_form": ([row.closed_form for row in iso], "1", "closed form, in the quantity's unit"),
                "core": ([row.core for row in iso], "1", "core, in the quantity's unit"),
                "unit": ([row.units for row in iso], "1", "unit of the quantity"),
                "source": ([row.source for row in iso], "1", "source of the closed form"),
            },
        ),
    }
    return Section(_found(problems.block_on_ring, hertz, swept, runs, iso), html, data)


def _found(
    ring: BlockOnRing, hertz: xr.Dataset, swept: xr.Dataset, runs: Mapping[int, RingRun], iso: list[IsoRow]
) -> tuple[str, ...]:
    finest = hertz.isel(cells=-1)
    run = runs[max(runs)]
    apart = np.abs(run.depths / np.array(ring.umeshmotion) - 1.0)
    spread, distance = against_tests(ring, run)
    standard = [row for row in iso if "ISO 21771" in row.source or "even" in row.name]
    return (
        f"Peak pressure of an elliptic contact is {percent(abs(float(finest.peak_error)))} off Hertz's at "
        f"{int(finest.cells)} x {int(finest.cells)} cells, and wear by a swept line is within "
        f"{percent(float(swept.difference[-1]))} of k q v_s/v_n under a light load.",
        f"The block on ring wears within {percent(apart.max())} of what Abaqus with UMESHMOTION published, in "
        f"{with_unit(run.seconds, 's', 2)} against the 25 h stated there; measured profiles are "
        f"{with_unit(distance, 'um', 2)} off it (root of the mean square), and {with_unit(spread, 'um', 2)} off "
        "their own mean.",
        f"Spur gears FZG C follow ISO 21771 and the even load of ISO 6336-2 to "
        f"{percent(max(abs(row.difference) for row in standard), 1)}; where the load along the face is solved, or "
        f"the standard is itself a fit, they differ by up to {percent(max(abs(row.difference) for row in iso))}.",
    )


# ---- Hertz


def _hertz(sizes: tuple[int, ...]) -> xr.Dataset:
    exact = elliptic_contact(LOAD, *CURVATURES, MODULUS)
    half = (exact.minor_half_axis, exact.major_half_axis)
    peak, approach, field, residual = [], [], [], []
    for size in sizes:
        # odd, so that a cell lies in the middle
        count = size + 1
        cell = (2.6 * half[0] / count, 2.6 * half[1] / count)
        x, y = ((np.arange(count) - 0.5 * (count - 1)) * one for one in cell)
        gap = 0.5 * CURVATURES[0] * x[:, None] ** 2 + 0.5 * CURVATURES[1] * y**2
        found = solve_half_space(gap, cell=cell, effective_modulus=MODULUS, load=LOAD)
        peak.append(found.pressure.max() / exact.peak_pressure - 1.0)
        approach.append(found.approach / exact.approach - 1.0)
        inside = np.maximum(1.0 - (x[:, None] / half[0]) ** 2 - (y / half[1]) ** 2, 0.0)
        pressure = exact.peak_pressure * np.sqrt(inside)
        field.append(float(np.linalg.norm(found.pressure - pressure) / np.linalg.norm(pressure)))
        residual.append(found.certificate.field_error)
    return dataset(
        {"cells": np.array(sizes) + 1},
        {
            "peak_error": (peak, "1", "peak pressure against Hertz's, relative"),
            "approach_error": (approach, "1", "approach against Hertz's, relative"),
            "field_error": (field, "1", "L2 error of the pressure against Hertz's, relative"),
            "solver_error": (residual, "1", "estimated L2 error of the pressure against the discrete solution"),
        },
        f"elliptic contact: half-axes {half[0]:.5f} and {half[1]:.5f} mm, {exact.peak_pressure:.2f} MPa",
    )


def _hertz_html(data: xr.Dataset) -> str:
    cells, errors = data.cells.values.astype(float), data.field_error.values
    order = -float(np.polyfit(np.log(cells), np.log(errors), 1)[0])

    def draw(ax: Any) -> None:
        ax.loglog(cells, errors, marker=MARKERS[0], color=COLOURS[0], label="pressure, whole field")
        ax.loglog(cells, np.abs(data.peak_error), marker=MARKERS[1], color=COLOURS[1], label="peak pressure")
        ax.loglog(cells, errors[0] * (cells[0] / cells) ** order, "--", color="#777777", linewidth=1.0,
                  label=f"order {order:.2f}")  # fmt: skip
        plain_log(ax.xaxis)
        ax.set_xlabel("Cells each way")
        ax.set_ylabel("Error against Hertz")
        legend_above(ax)

    rows = [
        (
            figure_text(float(row.cells)),
            f"{float(row.peak_error):+.1e}",
            f"{float(row.approach_error):+.1e}",
            f"{float(row.field_error):.1e}",
            f"{float(row.solver_error):.0e}",
        )
        for row in (data.isel(cells=k) for k in range(data.sizes["cells"]))
    ]
    head = ("cells each way", "peak pressure", "approach", "pressure, whole field", "left by the solver")
    text = f"<h3>Hertz</h3><p>An {data.attrs['note']}, solved by the half-space solver on its own.</p>"
    chart = card(
        "hertz", "Hertz's elliptic contact", f"The field's error falls with the cell to the power {order:.2f}.", draw
    )
    return text + cards([chart]) + table("Relative errors against Hertz", head, rows)


# ---- swept line


def _swept(quick: bool) -> xr.Dataset:
    """Deposited wear of a contact of finite width against the identity of the line."""
    changes: dict[str, Any] = {"numerics.face_slices": 21, "numerics.tooth_compliance": "rigid"}
    torques = (1600.0, 400.0, 100.0) if quick else (1600.0, 400.0, 100.0, 25.0)
    worst, widths = [], []
    for torque in torques:
        scene = sw.load_scene("face_gear_25x160").replace(changes | {"operation.pinion_torque_Nm": torque})
        teeth = plan(scene).loaded_teeth()
        state = teeth.load(np.zeros(teeth.grid.profile.shape))
        motion = worn_sweep(teeth, state)
        line = teeth.fine
        # even along the path: a rigid pressure of the footprint's width, whose load does not change
        free = (line.profile > line.low + 1e-6) & (line.profile < line.high - 1e-6)
        load = np.where(free, torque / 1600.0 * 300.0, 0.0)
        removed = teeth.removed(np.zeros(teeth.grid.profile.shape))
        mesh = wear_of_mesh(line, teeth.grid, removed, motion, load, teeth.half_width, teeth.problem.modulus)
        apart, greatest = 0.0, 0.0
        reach = 3.0 * teeth.half_width / line.spacing.mean()
        for i in range(3, teeth.grid.face.size - 3):
            places = line.profile[free[:, i], i]
            if not places.size:
                continue
            order = np.argsort(places)
            slide = motion.specific_sliding[free[:, i], i][order]
            nodes = teeth.grid.profile[i]
            even = np.interp(nodes, places[order], load[free[:, i], i][order])
            expected = wear_per_mesh(even, np.interp(nodes, places[order], slide), 1.0)
            cusp = places[order][slide.argmin()]
            inside = (nodes > places.min() + reach) & (nodes < places.max() - reach)
            inside &= np.abs(nodes - cusp) > reach
            if inside.any():
                apart = max(apart, float(np.abs(mesh[i] - expected)[inside].max()))
                greatest = max(greatest, float(expected[inside].max()))
        worst.append(apart / greatest)
        widths.append(teeth.half_width)
    return dataset(
        {"torque": np.array(torques)},
        {
            "half_width": (widths, "mm", "half-width of the contact at the pitch point"),
            "difference": (worst, "1", "greatest difference of wear from k q v_s/v_n over the greatest wear"),
        },
    )


def _swept_html(data: xr.Dataset) -> str:
    rows = [
        (
            with_unit(float(one.torque), "N m"),
            with_unit(float(one.half_width), "mm", 3),
            percent(float(one.difference)),
        )
        for one in (data.isel(torque=k) for k in range(data.sizes["torque"]))
    ]
    text = (
        "<h3>Swept-line identity</h3><p>Where a line under an even load moves on, Archard's wear is k q v_s/v_n, "
        "whatever its width. On the fresh face-gear flank, away from its borders and from the cusp at the pitch "
        "cone, the wear that finite footprints leave is compared with it, relative to the greatest wear.</p>"
    )
    return text + table("Wear by footprints against the identity", ("torque", "half-width", "difference"), rows)


# ---- spur gears


def _iso_html(rows: list[IsoRow]) -> str:
    cells = [
        (
            row.name,
            row.source,
            with_unit(row.closed_form, row.units, 5),
            with_unit(row.core, row.units, 5),
            f"{100 * row.difference:+.2g} %" if abs(row.difference) >= 1e-8 else "0 %",
        )
        for row in rows
    ]
    text = (
        "<h3>Spur gears in the manner of FZG type C</h3><p>Kinematics and the even load are closed forms. The "
        "standard knows no load that varies along the face, and its stiffness is itself a fit, to the theory of "
        "Weber and Banaschek.</p>"
    )
    return text + table("Spur gears against standards", ("quantity", "source", "closed form", "core", "apart"), cells)

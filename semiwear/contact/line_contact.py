"""Fidelity `line`: the compliance of a contact line is the stripe kernel, pressure across it is Hertz's.

The tooth compliance of a `ContactProblem` is increased by the stripe kernel of each line less the half-space
displacement at the mid-surface, with half-widths that follow the loads. Pressures across worn slices and over edges
are those of the plane contact of each slice under its load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.closed_forms.hertz import line_contact_pressure
from semiwear.closed_forms.stripe import stripe_table
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.footprint import OF_PRESSED_EDGES, Footprints
from semiwear.contact.line_solver import LineStatus, NearField
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.position_solver import LEAST_WIDTH, MARGIN, SharingRules, WornSlices, share_torque
from semiwear.contact.problem import FIRST_CAP, ContactProblem
from semiwear.contact.rounded_contact import Rounding
from semiwear.contact.slice_pressure import solve_slices
from semiwear.errors import ConvergenceError
from semiwear.threads import in_shares

_WIDTH_TOLERANCE = 1e-5  # of the half-widths, between two solutions
_ROUGH_WIDTH_TOLERANCE = 1e-3  # of the same, for loads that serve only as a start or for a step length
SMOOTH_WIDTH_TOLERANCE = 1e-9  # of the same, where results are to be smooth
_ROUNDING = 0.01  # of a typical approach: range in which slices come into contact where results are to be smooth
_CUT_IN = 0.25  # of a footprint's depth: an edge that cuts off less counts in part where results are to be smooth
_PRESSES_IN = 0.05  # of a typical approach, likewise: an edge that overlaps by less
_NARROWEST = 1.1 * LEAST_WIDTH  # of the typical half-width: least one of a pressed edge, with room for falling loads
_LIGHTEST = 0.03  # of the typical line load: assumed on an edge that hardly touches
_CAPS = 20  # sets of candidate slices tried; the approach grows less each time: two or three are enough


def solve_lines(
    problem: ContactProblem,
    worn: Footprints,
    start: TeethLoads | None = None,
    wear_compliance: FloatArray | None = None,
    positions: Sequence[int] | None = None,
    *,
    tolerance: float = _WIDTH_TOLERANCE,
    rounding: float = 0.0,
) -> TeethLoads:
    """Loads of the slices; as in `SolveLoads`, with half-widths to a relative tolerance.

    With a `rounding`, slices come into contact gradually, over this part of a typical approach (`rounded_contact`).
    """
    loads = problem.no_loads() if start is None else start.copy()
    softer = worn.softer if wear_compliance is None else worn.softer + wear_compliance
    slices = WornSlices(worn.gap.ravel(), worn.curvature.ravel(), worn.profile.ravel(), softer.ravel())
    typical_width = problem.usual_half_width
    near_field = NearField(problem.modulus, 2.0 * typical_width, stripe_table())
    rules = SharingRules(near_field, typical_width, problem.least_curvature, tolerance, problem.max_iterations)
    rounded = Rounding(rounding * problem.typical_approach, rounding * problem.usual_load) if rounding else None
    stepping = wear_compliance is not None
    known: BoolArray = np.asarray(loads.force.any(axis=1).reshape(problem.pairs, -1).any(axis=0))

    def solve(part: IntArray) -> None:
        for position in part:
            at, is_known = int(position), bool(known[position])
            _solve_position(problem, at, worn, slices, rules, rounded, loads, known=is_known, stepping=stepping)

    chosen = np.arange(problem.per_cycle) if positions is None else np.array(positions, dtype=np.int64)
    in_shares(solve, chosen)
    if not stepping:
        worn.require_followed(loads.force, chosen, problem.per_cycle)
    return loads


def line_pressures(problem: ContactProblem, loads: TeethLoads, worn: Footprints, margin: float) -> SlicePressures:
    """Hertz's pressures, and exact ones across worn slices and edges; as in `Fidelity`."""
    line_load, lines = problem.line_load(loads), problem.lines
    hertz = line_contact_pressure(line_load, worn.curvature, problem.modulus)
    distance = np.minimum(worn.profile - lines.low, lines.high - worn.profile) * lines.spacing
    other = worn.edge | (distance < margin) | worn.removed.varies
    exact, _ = solve_slices(lines, worn, np.where(other, line_load, 0.0), problem.modulus, margin)
    return SlicePressures(
        np.where(other, exact.inner, hertz), np.where(other, exact.place, worn.profile), exact.border
    )


def with_pressed_edges(
    problem: ContactProblem,
    worn: Footprints,
    loads: TeethLoads,
    before: Footprints,
    rolls: BoolArray | None = None,
    *,
    smooth: bool = False,
) -> Footprints:
    """Contact of edges that are pressed, or nearly so, from the plane contact of each such slice under its load.

    Hertz's law with a footprint's mean gap is too stiff where pressure rests on the rounding of an edge, and too
    soft where only the wall of a groove bears load. An edge that is pressed in `before` stays so: under high
    load it may hold the flanks farther apart than its footprint's mean gap. As in `WithEdges`; `smooth` is that
    of `solve_slices`.
    """
    lines, modulus = problem.lines, problem.modulus
    approach = np.tile(loads.rotation, problem.pairs)[:, None] * lines.lever_arm
    near = problem.is_near(lines) if worn.near is None else worn.near
    pressed = (worn.edge & near & (worn.least < approach)) | (before.gap != worn.gap)
    if not pressed.any():
        return worn
    if rolls is not None:
        pressed &= rolls[:, None]
    load = np.where(pressed, np.maximum(problem.line_load(loads), _LIGHTEST * problem.usual_load), 0.0)
    touched = solve_slices(lines, worn, load, modulus, 0.0, smooth=smooth)[1]
    touched = replace(touched, softer=worn.softer.copy())
    # load sharing limits half-widths from below: a narrower contact is softer by the same logarithm
    per_load = 2.0 / (np.pi * modulus)
    closes = per_load * load[pressed]
    width = np.sqrt(2.0 * closes / touched.curvature[pressed])
    wide = np.maximum(width, _NARROWEST * problem.usual_half_width)
    touched.softer[pressed] = per_load / lines.length[pressed] * np.log(wide / width)
    touched.curvature[pressed] = 2.0 * closes / wide**2
    if smooth:
        # an edge that just comes close, or begins to cut off a footprint, takes effect gradually
        nearer = (approach - worn.least)[pressed] / (_PRESSES_IN * problem.typical_approach)
        part = np.clip(worn.cut[pressed] / _CUT_IN, 0.0, 1.0) * np.clip(nearer, 0.0, 1.0)
        for name in OF_PRESSED_EDGES:
            whole, none = getattr(touched, name), getattr(worn, name)
            whole[pressed] = none[pressed] + part * (whole[pressed] - none[pressed])
    if rolls is not None:
        for name in OF_PRESSED_EDGES:
            getattr(touched, name)[~rolls] = getattr(before, name)[~rolls]
    return touched


LINE = Fidelity(
    solve_lines, with_pressed_edges, line_pressures, roughly=partial(solve_lines, tolerance=_ROUGH_WIDTH_TOLERANCE)
)
"""Line loads, with Hertz's pressure across them."""
SMOOTH_LINE = Fidelity(
    partial(solve_lines, tolerance=SMOOTH_WIDTH_TOLERANCE, rounding=_ROUNDING),
    partial(with_pressed_edges, smooth=True),
    line_pressures,
)
"""The same for differences of runs: half-widths are iterated further, slices and pressed edges yield smoothly."""


def _solve_position(
    problem: ContactProblem,
    position: int,
    worn: Footprints,
    slices: WornSlices,
    rules: SharingRules,
    rounding: Rounding | None,
    loads: TeethLoads,
    *,
    known: bool,
    stepping: bool,
) -> None:
    rolls, lever = problem.rolls_of(position), float(problem.longest_lever[position])
    reached = MARGIN * float(loads.rotation[position]) * lever if known else _first_cap(problem, rolls, worn)
    for _ in range(_CAPS):
        candidates = problem.candidates(position, reached)
        torque, expected = float(problem.torque[position]), float(loads.rotation[position])
        status, rotation, iterations, change, balance, complementarity = share_torque(
            candidates, slices, torque, rules, rounding, rolls, expected, reached, loads.force, loads.half_width
        )
        if status != LineStatus.CONVERGED:
            where = f"load sharing stopped at mesh position {position}/{problem.per_cycle}: "
            shorter = ", or take shorter wear steps (more numerics.wear_steps)" if stepping else ""
            raise ConvergenceError(where + _reason(LineStatus(status), change, problem) + shorter)
        loads.rotation[position], loads.iterations[position] = rotation, iterations
        loads.balance[position], loads.complementarity[position] = balance, complementarity
        reached = rotation * lever + (0.0 if rounding is None else rounding.depth)
        if reached <= candidates.cap:
            return
    raise ConvergenceError(
        f"load sharing stopped at mesh position {position}/{problem.per_cycle}: the approach, {reached:.3g} mm by "
        "now, grows with every slice that may touch; check the torque, the materials and "
        "numerics.tooth_compliance"
    )


def _first_cap(problem: ContactProblem, rolls: IntArray, worn: Footprints) -> float:
    """Separation within which slices may touch where no loads are known [mm]."""
    near = problem.is_near(problem.lines)[rolls]
    nearest = float(worn.gap[rolls][near].min()) if near.any() else 0.0
    return FIRST_CAP * problem.typical_approach + nearest


def _reason(status: LineStatus, change: float, problem: ContactProblem) -> str:
    if status == LineStatus.WIDTHS_CHANGE:
        return (
            f"half-widths still change by {change:.1e}; raise numerics.max_iterations above {problem.max_iterations}"
        )
    if status == LineStatus.NO_CONTACT_SET:
        return "the contact set does not settle; change numerics.face_slices"
    return problem.why_not_positive()

"""Fidelity `line`: the compliance of a contact line is the stripe kernel, pressure across it is Hertz's.

To the tooth compliance of a `ContactProblem` comes the stripe kernel of each line less the half-space displacement at
the mid-surface, with half-widths that follow the loads. Pressures across worn slices and over edges are those of the
plane contact of each slice under its load.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from semiwear.closed_forms.hertz import line_contact_pressure
from semiwear.closed_forms.stripe import stripe_table
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.footprint import Footprints
from semiwear.contact.line_solver import LineStatus, NearField, Slices, solve_line_loads
from semiwear.contact.loads import SlicePressures, TeethLoads
from semiwear.contact.problem import FIRST_CAP, Candidates, ContactProblem
from semiwear.contact.slice_pressure import solve_slices
from semiwear.errors import ConvergenceError
from semiwear.threads import in_shares

__all__ = ["LINE", "line_pressures", "solve_lines", "with_pressed_edges"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_LEAST_WIDTH = 0.1  # of the usual half-width: what slices hardly loaded are given
_WIDTH_TOLERANCE = 1e-5  # of the half-widths, between two solutions
_LIGHTEST = 0.03  # of the usual line load: what an edge that hardly touches is taken to bear
_MARGIN = 1.15  # of the expected approach
_CAPS = 20  # more candidates let the approach grow less, so that two or three are enough


def solve_lines(
    problem: ContactProblem,
    worn: Footprints,
    start: TeethLoads | None = None,
    wear_compliance: FloatArray | None = None,
    positions: Sequence[int] | None = None,
) -> TeethLoads:
    """Loads of the slices; as in `SolveLoads`."""
    loads = problem.no_loads() if start is None else start.copy()

    def solve(share: IntArray) -> None:
        for position in share:
            _solve_position(problem, int(position), worn, loads, wear_compliance)

    in_shares(solve, np.arange(problem.per_cycle) if positions is None else np.array(positions, dtype=np.int64))
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
    problem: ContactProblem, worn: Footprints, loads: TeethLoads, before: Footprints
) -> Footprints:
    """Contact of edges that are pressed, or nearly so, from the plane contact of each such slice under its load.

    Hertz's law with a footprint's mean gap is too stiff where pressure leans on the rounding of an edge, and too
    soft where the wall of a groove is all that bears. An edge that is pressed in `before` stays so: under much
    load it may hold the flanks farther apart than its footprint's mean gap says.
    """
    lines, modulus = problem.lines, problem.modulus
    approach = np.tile(loads.rotation, problem.pairs)[:, None] * lines.lever_arm
    near = problem.is_near(lines) if worn.near is None else worn.near
    pressed = (worn.edge & near & (worn.least < approach)) | (before.gap != worn.gap)
    if not pressed.any():
        return worn
    load = np.where(pressed, np.maximum(problem.line_load(loads), _LIGHTEST * problem.usual_load), 0.0)
    touched = solve_slices(lines, worn, load, modulus, 0.0)[1]
    # no half-width is less than the load sharing allows: as much farther away as it is then too stiff
    closes, least = 2.0 / (np.pi * modulus) * load[pressed], _LEAST_WIDTH * problem.usual_half_width
    width = np.sqrt(2.0 * closes / touched.curvature[pressed])
    touched.gap[pressed] += closes * np.log(np.maximum(least / width, 1.0))
    touched.curvature[pressed] = 2.0 * closes / np.maximum(width, least) ** 2
    return touched


LINE = Fidelity(solve_lines, with_pressed_edges, line_pressures)
"""Line loads, with Hertz's pressure across them."""


def _solve_position(
    problem: ContactProblem,
    position: int,
    worn: Footprints,
    loads: TeethLoads,
    wear_compliance: FloatArray | None,
) -> None:
    rolls = problem.rolls_of(position)
    if loads.force[rolls].any():
        reached = _MARGIN * float(loads.rotation[position] * problem.lines.lever_arm[rolls].max())
    else:
        reached = _first_cap(problem, rolls, worn)
    for _ in range(_CAPS):
        candidates = problem.candidates(position, reached)
        rotation = _share_torque(problem, position, candidates, worn, loads, wear_compliance, reached)
        reached = rotation * float(candidates.lever.max())
        if reached <= candidates.cap:
            if wear_compliance is None:
                worn.require_followed(loads.force, rolls, f"{position}/{problem.per_cycle}")
            return
    raise ConvergenceError(
        f"load sharing stopped at mesh position {position}/{problem.per_cycle}: the approach, {reached:.3g} mm by "
        "now, grows with every slice that is let touch; check the torque, the materials and "
        "numerics.tooth_compliance"
    )


def _first_cap(problem: ContactProblem, rolls: IntArray, worn: Footprints) -> float:
    """Separation within which slices are let touch where no loads are known [mm]."""
    near = problem.is_near(problem.lines)[rolls]
    nearest = float(worn.gap[rolls][near].min()) if near.any() else 0.0
    return FIRST_CAP * problem.typical_approach + nearest


def _share_torque(
    problem: ContactProblem,
    position: int,
    candidates: Candidates,
    worn: Footprints,
    loads: TeethLoads,
    wear_compliance: FloatArray | None,
    cap: float,
) -> float:
    """Loads of a mesh position; returns the rotation.

    Where no loads are known, slices whose fresh separation is below `cap` [mm] are first let touch.
    """
    gap = worn.gap.ravel()[candidates.index]
    least = float(gap.min())
    # only what is nearer than the approach can touch; where the start knows it, that spares much
    if loads.force.ravel()[candidates.index].any():
        expected = least + _MARGIN * (loads.rotation[position] * candidates.lever - least)
        chosen = np.flatnonzero(gap < expected)
    else:
        chosen = np.flatnonzero(candidates.least < cap)
    if chosen.size == 0:
        chosen = np.arange(gap.size)
    rotation = _share_among(problem, position, candidates, chosen, worn, loads, wear_compliance)
    if chosen.size < gap.size and np.any(np.delete(gap - rotation * candidates.lever, chosen) < 0.0):
        every = np.arange(gap.size)
        rotation = _share_among(problem, position, candidates, every, worn, loads, wear_compliance)
    return rotation


def _share_among(
    problem: ContactProblem,
    position: int,
    candidates: Candidates,
    chosen: IntArray,
    worn: Footprints,
    loads: TeethLoads,
    wear_compliance: FloatArray | None,
) -> float:
    """Loads of chosen candidates; returns the rotation."""
    index, usual = candidates.index[chosen], problem.usual_half_width
    gap, curvature = worn.gap.ravel()[index], np.maximum(worn.curvature.ravel()[index], problem.least_curvature)
    lever, length, arc = candidates.lever[chosen], candidates.length[chosen], candidates.arc[chosen]
    starts = np.searchsorted(chosen, candidates.starts)
    # from where the first slice touches: a misplaced pinion may be millimetres off, a light approach nanometres
    touching = float((gap / lever).min())
    gap -= touching * lever
    static = candidates.compliance(candidates.static, chosen, worn, wear_compliance)

    torque = float(problem.torque[position])
    active = loads.force.ravel()[index] > 0.0
    floor = np.full(index.size, _LEAST_WIDTH * usual)
    if active.any():
        width = np.maximum(loads.half_width.ravel()[index], floor)
    else:
        active, width = gap <= np.quantile(gap, 0.25), np.full(index.size, usual)
    status, rotation, force, slack, iterations, change_of_width = solve_line_loads(
        Slices(static, gap, lever, arc, length, floor, curvature, starts),
        NearField(candidates.near_field, problem.modulus, 2.0 * usual, *stripe_table()),
        torque, _WIDTH_TOLERANCE, problem.max_iterations, active, width,
    )  # fmt: skip
    if status != LineStatus.CONVERGED:
        where = f"load sharing stopped at mesh position {position}/{problem.per_cycle}: "
        shorter = "" if wear_compliance is None else ", or take shorter wear steps (more numerics.wear_steps)"
        raise ConvergenceError(where + _reason(LineStatus(status), change_of_width, problem.max_iterations) + shorter)
    loads.force[problem.rolls_of(position)] = 0.0
    loads.force.ravel()[index] = force
    loads.half_width.ravel()[index] = np.where(force > 0.0, width, 0.0)
    loads.rotation[position] = touching + rotation
    loads.iterations[position] = iterations
    loads.balance[position] = abs(float(lever @ force) / torque - 1.0)
    # the Hertz pressure goes with the root of line load times curvature
    pressure = np.sqrt(force / length * curvature)
    worst = max(float((pressure * np.abs(slack)).max() / pressure.max()), float(-slack.min()))
    loads.complementarity[position] = worst / float((lever * rotation - gap).max())
    return touching + float(rotation)


def _reason(status: LineStatus, change: float, max_iterations: int) -> str:
    if status == LineStatus.WIDTHS_CHANGE:
        return f"half-widths still change by {change:.1e}; raise numerics.max_iterations above {max_iterations}"
    if status == LineStatus.NO_CONTACT_SET:
        return "the contact set does not settle; change numerics.face_slices"
    return "the compliance is not positive definite; raise numerics.harmonics or use fewer numerics.face_slices"

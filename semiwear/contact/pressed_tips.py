"""Tip edges in contact: their load, and the tip relief that would free them.

A deflected pair brings the next one into contact before its turn: the tip of the driven body meets the root of the
driving one where the line of action has not been reached, and the tip of the driving body leaves it after its end.
A tip is freed by a relief as deep as the flanks would overlap there if the other slices bore all of the load
(Walker 1938, The Engineer 166, 409-412 and 435-436). A relief takes load off the flank beside the tip as well,
which then bends the others more: where contact lines run obliquely into the tip a little more may be needed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semiwear.arrays import BoolArray, FloatArray, IntArray
from semiwear.contact.line_contact import SMOOTH_WIDTH_TOLERANCE, solve_lines
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.contact.problem import Candidates
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING

_OPENED = 1.0  # mm: a gap that no load closes
_TOLERANCE = 1e-3  # of half-widths, between two solutions: the approach is then accurate to 1e-4


def pressed_tips(teeth: LoadedTeeth, state: LoadedState) -> BoolArray:
    """Slices that bear load on the rounding of a body's tip, where their footprint is cut off; (body, roll, face)."""
    return _at_tips(teeth, state) & _on_edge(state)


def _on_edge(state: LoadedState) -> BoolArray:
    return (state.loads.force > 0.0) & state.coarse.edge


def _at_tips(teeth: LoadedTeeth, state: LoadedState) -> BoolArray:
    """Slices that are nearer to a body's tip than to the other end, and within a half-width of it."""
    lines, worn = teeth.lines, state.coarse
    # the driving body's tip cuts slices of the driven flank off at their lower end
    below, above = (worn.profile - lines.low) * lines.spacing, (lines.high - worn.profile) * lines.spacing
    at_tip = np.zeros((len(BODIES), *below.shape), dtype=bool)
    at_tip[DRIVING] = (lines.low_edge_radius > 0.0) & (below <= above) & (below < teeth.half_width)
    at_tip[DRIVEN] = (lines.high_edge_radius > 0.0) & (above < below) & (above < teeth.half_width)
    return at_tip


def tip_load_share(teeth: LoadedTeeth, state: LoadedState) -> FloatArray:
    """Share of the load on slices whose tip edge is in contact, (roll, body)."""
    moment = state.loads.force * teeth.lines.lever_arm
    total = moment.sum(axis=1).reshape(teeth.rolls.pairs, -1).sum(axis=0)
    borne = np.sum(moment * pressed_tips(teeth, state), axis=2)
    return np.asarray((borne / np.tile(total, teeth.rolls.pairs)).T)


def relief_to_free(teeth: LoadedTeeth, state: LoadedState) -> FloatArray:
    """Relief that would free the pressed tips of load [mm], (body,); 0 where none is pressed.

    At every mesh position the loads are shared without the slices at both tips, at fidelity `line`; the relief is the
    approach less their gap and less the deflection that the other loads cause there. The near field of the half-space
    is left out, which does not make the relief less.
    """
    at_tips = _at_tips(teeth, state)
    pressed = at_tips & _on_edge(state)
    relief = np.zeros(len(BODIES))
    problem = teeth.problem
    without: BoolArray = np.logical_or.reduce(at_tips, axis=0)
    # where only tips bear load, no relief frees them all
    pressing = np.unique(np.flatnonzero(pressed.any(axis=(0, 2))) % teeth.rolls.phase.size)
    start = state.loads.copy()
    start.force[without] = 0.0
    positions = [int(position) for position in pressing if start.force[problem.rolls_of(int(position))].any()]
    opened = replace(state.coarse, gap=state.coarse.gap + _OPENED * without)
    tolerance = SMOOTH_WIDTH_TOLERANCE if teeth.smooth else _TOLERANCE
    loads = solve_lines(problem, opened, start, positions=positions, tolerance=tolerance)
    for position in positions:
        turned = float(loads.rotation[position] * problem.longest_lever[position])
        candidates = problem.candidates(position, turned)
        counts = pressed.reshape(len(BODIES), -1)[:, candidates.flat]
        slices = np.flatnonzero(counts.any(axis=0))
        overlap = _overlap(candidates, slices, float(loads.rotation[position]), loads, state)
        relief = np.maximum(relief, np.where(counts[:, slices], overlap, 0.0).max(axis=1, initial=0.0))
    return relief


def _overlap(
    candidates: Candidates, slices: IntArray, rotation: float, loads: TeethLoads, state: LoadedState
) -> FloatArray:
    """How far the flanks overlap in some of the candidates of a mesh position [mm]."""
    flat = candidates.flat[slices]
    separation = state.coarse.least.ravel()[flat]
    return rotation * candidates.lever[slices] - separation - candidates.deflection(slices, loads.force, state.coarse)

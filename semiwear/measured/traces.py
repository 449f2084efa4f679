r"""Profile and lead traces of a flank, and the surface interpolated between them.

A measuring machine traces a profile at one face coordinate and a lead at one diameter; every chart has its own zero.
The surface between the traces is their transfinite interpolation: with P the profiles blended along the face, L the
leads blended along the profile and C their common values at the crossings, blended in both directions,

.. math:: D(u, v) = P(u, v) + L(u, v) - C(u, v) .

With one profile and one lead it is their sum less the value at the crossing: the flank is assumed to have the same
profile everywhere along the face, and no twist. With two profiles or leads the twist between them is linear.
Deviations between the traces, such as wear that is deepest there, are not measured: if wear varies along the face,
two or three profiles are the least.

The zeros of the charts are chosen so that traces agree at their crossings, by least squares; the difference that
remains is reported as `mismatch`.

Source: Gordon, SIAM J. Numer. Anal. 8 (1971) 158-177 (blending of curves); VDI/VDE 2612-1:2018, ISO 1328-1:2013
(traces and their signs: positive for material in excess).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.measured.nominal import NominalFlank, nominal_flank
from semiwear.meshing.deviation_grid import DeviationGrid
from semiwear.plain_text import one_of
from semiwear.scene import Scene

KINDS = ("profile", "lead")
FLANKS = ("left", "right")

_UM = 1e-3
_LEAST = 4  # points of a trace
_ROWS, _COLUMNS = 61, 61  # of the surface
_ZEROS = ("free", "common")
_SAME = 0.02  # mm: traces closer than this are taken as one line on several teeth, and averaged
_SAMPLES = 401  # of the diameter along the profile
_GREATEST = 5000.0  # um: greater deviations are a mistake of units


@dataclass(frozen=True)
class Trace:
    """Deviations along one line of a flank.

    Attributes
    ----------
    kind : str
        ``"profile"`` or ``"lead"``.
    flank : str
        ``"left"`` or ``"right"``, as the machine names it.
    tooth : int
    diameter : (n,) array [mm]
        About the body's axis; constant for a lead.
    z : (n,) array [mm]
        From the lower end of the face along the axis; constant for a profile.
    deviation : (n,) array [um]
        Positive for material in excess.
    """

    kind: str
    flank: str
    tooth: int
    diameter: FloatArray
    z: FloatArray
    deviation: FloatArray


@dataclass(frozen=True)
class TracedFlank:
    """Surface of a flank from traces.

    Attributes
    ----------
    grid : DeviationGrid
        Of the flank, in millimetres from its root end and from the lower end of its face: input of `register`,
        `measured_wear`, `calibrate` and `write_deviation_grid`.
    profiles, leads : int
        Numbers of traces used, where the same trace on several teeth counts once.
    mismatch : float [um]
        Greatest difference of profiles and leads at their crossings, after the choice of their zeros.
    assumptions : tuple of str
        Assumptions of the interpolation, in words.
    """

    grid: DeviationGrid
    profiles: int
    leads: int
    mismatch: float
    assumptions: tuple[str, ...]

    def __str__(self) -> str:
        used = f"{self.profiles} profiles and {self.leads} leads, which differ by {self.mismatch:.2g} um at crossings"
        return "\n".join([f"flank from {used}", *(f"- {text}" for text in self.assumptions)])


def flank_from_traces(
    scene: Scene,
    traces: Sequence[Trace],
    body: str = "gear",
    *,
    flank: str | None = None,
    tooth: int | None = None,
    zeros: str = "free",
) -> TracedFlank:
    """The surface of a flank from its profile and lead traces.

    Parameters
    ----------
    scene : Scene
        With a cylindrical pair, or a face gear pair whose pinion was measured.
    traces : sequence of Trace
        As from `read_traces`: one or more profiles; leads are optional.
    body : str
    flank : str, optional
        ``"left"`` or ``"right"``: the flank that bears the load. Needed if there are traces of both.
    tooth : int, optional
        Use the traces of this tooth only. Default: the mean of all teeth measured at the same place.
    zeros : str
        ``"free"`` (default): every chart has its own zero; without leads all profiles get the same mean.
        ``"common"``: all traces have the same zero, as in a topography, a grid of many profiles.

    Returns
    -------
    TracedFlank

    Raises
    ------
    SceneError
        For traces that are too short, off the flank, not finite, or of both flanks; lists all problems.
    """
    nominal = nominal_flank(scene, body)
    if zeros not in _ZEROS:
        raise SceneError.of("zeros", zeros, one_of(_ZEROS))
    if scene.gear_pair.type == "face_gear" and body == "gear":
        raise SceneError.of(
            "body", body, '"pinion" of a face gear pair', "a face gear is measured as a grid of points"
        )
    chosen = _chosen(traces, flank, tooth)
    _check(chosen, nominal)
    low, high = nominal.face_ends
    root, tip = (float(value[0]) for value in nominal.limits(np.array([0.5 * (low + high)])))
    u, v = np.linspace(0.0, tip - root, _ROWS), np.linspace(0.0, high - low, _COLUMNS)
    above_root = _above_root(nominal, root, tip)
    profiles, leads = [], []
    for trace in chosen:
        height = above_root(trace.diameter)
        if trace.kind == "profile":
            profiles.append((float(np.mean(trace.z)), _read(height, trace.deviation, u)))
        elif trace.kind == "lead":
            leads.append((float(np.mean(height)), _read(trace.z, trace.deviation, v)))
    profile_lines, lead_lines, common = _merged(profiles), _merged(leads), zeros == "common"
    deviation, mismatch = _surface((u, v), profile_lines, lead_lines, common)
    counts = len(profile_lines[0]), len(lead_lines[0])
    return TracedFlank(
        DeviationGrid(u, v, _UM * deviation, "mm", "mm"),
        *counts,
        mismatch,
        _assumed(*counts, chosen, common),
    )


def _assumed(profiles: int, leads: int, chosen: Sequence[Trace], common: bool) -> tuple[str, ...]:
    texts = []
    if profiles == 1:
        texts.append("the profile is the same everywhere along the face, but for a shift along the lead")
    else:
        texts.append("between profiles, and beyond the outermost, deviations are blended linearly or held")
    if common:
        texts.append("all traces have the same zero")
    elif leads:
        texts.append("each chart's zero is free: traces are shifted to agree at their crossings")
    else:
        texts.append("no lead was measured: the profiles' mean is the same along the face")
    teeth = len({trace.tooth for trace in chosen})
    if teeth > 1:
        texts.append(f"{teeth} teeth were measured and are averaged")
    texts.append("beyond the measured range of a trace its last value is kept")
    return tuple(texts)


def _chosen(traces: Sequence[Trace], flank: str | None, tooth: int | None) -> list[Trace]:
    measured_flanks = {trace.flank for trace in traces}
    if flank is None and len(measured_flanks) > 1:
        raise SceneError.of("flank", None, one_of(FLANKS), "the file has both: say which bears the load")
    chosen = [trace for trace in traces if flank in (None, trace.flank) and tooth in (None, trace.tooth)]
    if not any(trace.kind == "profile" for trace in chosen):
        teeth = ", ".join(str(number) for number in sorted({trace.tooth for trace in traces}))
        found = f"no profile of the {flank or 'measured'} flank" + (f" of tooth {tooth}" if tooth is not None else "")
        raise SceneError.of(
            "traces", found, f"one profile or more; teeth: {teeth or 'none'}", "choose what was measured"
        )
    return chosen


def _check(traces: Sequence[Trace], nominal: NominalFlank) -> None:
    """Refuse traces that cannot lie on the flank."""
    low, high = nominal.face_ends
    root, tip = nominal.limits(np.array([low]))
    limits = 2.0 * nominal.place(np.array([low, low]), np.array([root[0], tip[0]]))[1]
    small, large, width = float(limits.min()), float(limits.max()), high - low
    problems = []
    for trace in traces:
        name = f"{trace.kind} of tooth {trace.tooth}, {trace.flank}"
        values = np.concatenate([trace.diameter, trace.z, trace.deviation])
        if len(trace.deviation) < _LEAST or not np.all(np.isfinite(values)):
            found = f"{len(trace.deviation)} points" if np.all(np.isfinite(values)) else "numbers that are not finite"
            problems.append(Problem(name, found, f"{_LEAST} finite points or more", "measure or export it again"))
            continue
        if np.abs(trace.deviation).max() > _GREATEST:
            found = f"a deviation of {np.abs(trace.deviation).max():g} um"
            problems.append(Problem(name, found, f"at most {_GREATEST:g} um", "check the units"))
        middle = float(np.median(trace.diameter))
        if not small - 0.1 * (large - small) <= middle <= large + 0.1 * (large - small):
            found, allowed = f"a diameter of {middle:g} mm", f"on the flank, {small:.4g} to {large:.4g} mm"
            problems.append(Problem(name, found, allowed, "check the body, and that it is a diameter in mm"))
        if trace.z.min() < -0.05 * width or trace.z.max() > 1.05 * width:
            found, allowed = f"z from {trace.z.min():g} to {trace.z.max():g} mm", f"on the face, 0 to {width:g} mm"
            problems.append(Problem(name, found, allowed, "count z from the lower end of the face"))
    if problems:
        raise SceneError(problems, "traces")


def _above_root(nominal: NominalFlank, root: float, tip: float) -> Callable[[FloatArray], FloatArray]:
    """Function from diameters to distances along the profile from its root end, both [mm]."""
    middle = 0.5 * sum(nominal.face_ends)
    beyond = 0.1 * (tip - root)
    profile = np.linspace(root - beyond, tip + beyond, _SAMPLES)
    diameter = 2.0 * nominal.place(np.full(_SAMPLES, middle), profile)[1]
    order = np.argsort(diameter)
    return lambda diameters: np.asarray(np.interp(diameters, diameter[order], profile[order]) - root)


def _read(at: FloatArray, deviation: FloatArray, nodes: FloatArray) -> FloatArray:
    """Deviations at equidistant nodes: linear between the means over the cell of each node and the trace's ends."""
    order = np.argsort(at)
    at, deviation = at[order], deviation[order]
    step = nodes[1] - nodes[0]
    _, cell, count = np.unique(np.round((at - nodes[0]) / step), return_inverse=True, return_counts=True)
    means = [np.bincount(cell, values) / count for values in (at, deviation)]
    mean_at, values = (
        np.concatenate([ends[:1], mean[1:-1], ends[-1:]]) for ends, mean in zip((at, deviation), means, strict=True)
    )
    return np.asarray(np.interp(nodes, mean_at, values))


def _merged(lines: list[tuple[float, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Positions and values of lines in the order of position, with those at the same position averaged."""
    groups: list[tuple[list[float], list[FloatArray]]] = []
    for position, values in sorted(lines, key=lambda line: line[0]):
        if groups and position - groups[-1][0][-1] < _SAME:
            groups[-1][0].append(position)
            groups[-1][1].append(values)
        else:
            groups.append(([position], [values]))
    positions = np.array([np.mean(at) for at, _ in groups])
    return positions, np.array([np.mean(values, axis=0) for _, values in groups])


def _surface(
    at: tuple[FloatArray, FloatArray],
    profile_lines: tuple[FloatArray, FloatArray],
    lead_lines: tuple[FloatArray, FloatArray],
    common: bool,
) -> tuple[FloatArray, float]:
    """Blended deviations (u, v), and the greatest mismatch at the crossings."""
    (u, v), (at_v, profiles), (at_u, leads) = at, profile_lines, lead_lines
    along = _blending(at_v, v)  # (v, profiles)
    if not len(at_u):
        level = profiles.mean(axis=1, keepdims=True)
        if not common:
            profiles = profiles - level + level[0]  # the zero of the first profile is kept
        return profiles.T @ along.T, 0.0
    across = _blending(at_u, u)  # (u, leads)
    of_profiles = np.array([np.interp(at_u, u, profile) for profile in profiles])  # (profiles, leads)
    of_leads = np.array([np.interp(at_v, v, lead) for lead in leads]).T
    if not common:
        profile_zeros, lead_zeros = _zeros(of_leads - of_profiles)
        profiles, leads = profiles + profile_zeros[:, None], leads + lead_zeros[:, None]
        of_profiles, of_leads = of_profiles + profile_zeros[:, None], of_leads + lead_zeros
    crossings = 0.5 * (of_profiles + of_leads)
    surface = profiles.T @ along.T + across @ leads - across @ crossings.T @ along.T
    return np.asarray(surface), float(np.abs(of_profiles - of_leads).max())


def _zeros(difference: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Zeros a of profiles and b of leads with P + a = L + b at every crossing, by least squares; the first a is 0.

    Parameters
    ----------
    difference : (profiles, leads) array
        L - P.
    """
    rows, columns = difference.shape
    matrix = np.zeros((rows * columns + 1, rows + columns))
    crossing = np.arange(rows * columns)
    matrix[crossing, crossing // columns], matrix[crossing, rows + crossing % columns] = 1.0, -1.0
    matrix[-1, 0] = 1.0
    found = np.linalg.lstsq(matrix, np.append(difference.ravel(), 0.0), rcond=None)[0]
    return found[:rows], found[rows:]


def _blending(lines: FloatArray, nodes: FloatArray) -> FloatArray:
    """Weights (nodes, lines): linear between the positions of the lines, constant beyond the outermost."""
    return np.stack([np.interp(nodes, lines, unit) for unit in np.eye(len(lines))], axis=1)

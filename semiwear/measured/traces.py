r"""Profile and lead traces of a flank, and the surface that they tell.

A measuring machine runs along a profile at one place of the face and along a lead at one diameter; a chart has a zero
of its own. The surface between traces is what they do not contradict, by transfinite interpolation: with P the
profiles blended along the face, L the leads blended along the profile and C their common values at the crossings,
blended both ways,

.. math:: D(u, v) = P(u, v) + L(u, v) - C(u, v) .

With one profile and one lead it is their sum less the value at the crossing: the flank is taken to have the same
profile everywhere along the face, and no twist. With two profiles or leads the twist between them is linear. What a
flank does between its traces, such as wear that is deepest off both, is not seen: two or three profiles across the
face are the least where wear is uneven along it.

The zeros of charts are chosen so that traces agree at their crossings, in least squares; what they still
differ by there is told.

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
_SAME = 0.02  # mm: traces at the same place are of several teeth, and averaged
_SAMPLES = 401  # along the flank, to find a diameter
_GREATEST = 5000.0  # um: more is a mistake of units


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
        About the body's axis; of a lead all the same.
    z : (n,) array [mm]
        From the lower end of the face along the axis; of a profile all the same.
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
    """A surface made of traces.

    Attributes
    ----------
    grid : DeviationGrid
        Of the flank, in millimetres from its root end and from the lower end of its face: `register`, `measured_wear`
        and `calibrate` take it, `write_deviation_grid` writes it.
    profiles, leads : int
        Traces that it was made of, those of several teeth at one place counted once.
    mismatch : float [um]
        Greatest difference of profiles and leads at their crossings, after their zeros were chosen.
    assumptions : tuple of str
        What was assumed.
    """

    grid: DeviationGrid
    profiles: int
    leads: int
    mismatch: float
    assumptions: tuple[str, ...]

    def __str__(self) -> str:
        made = f"{self.profiles} profiles and {self.leads} leads, which differ by {self.mismatch:.2g} um at crossings"
        return "\n".join([f"flank from {made}", *(f"- {text}" for text in self.assumptions)])


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
        As `read_traces` gives them: one profile or more; leads may be missing.
    body : str
    flank : str, optional
        ``"left"`` or ``"right"``: the one that bears the load. Needed where the traces are of both.
    tooth : int, optional
        Of this tooth alone. Default: the mean of all teeth measured at one place.
    zeros : str
        ``"free"`` (default): every trace is a chart with a zero of its own; without leads all profiles get the same
        mean. ``"common"``: all traces have the same zero, as of a topography, a grid of many profiles.

    Returns
    -------
    TracedFlank

    Raises
    ------
    SceneError
        For traces that are too short, off the flank, not finite, or of both flanks, all at once.
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
    profile_at, length, width = _profile_of_diameter(nominal), tip - root, high - low
    u, v = np.linspace(0.0, length, _ROWS), np.linspace(0.0, width, _COLUMNS)
    lines = {
        kind: _merged(
            [
                (
                    float(np.mean(one.z if kind == "profile" else profile_at(one.diameter) - root)),
                    _read(profile_at(one.diameter) - root, one.deviation, u)
                    if kind == "profile"
                    else _read(one.z, one.deviation, v),
                )
                for one in chosen
                if one.kind == kind
            ]
        )
        for kind in KINDS
    }
    common = zeros == "common"
    deviation, mismatch = _surface((u, v), lines["profile"], lines["lead"], common)
    profiles, leads = len(lines["profile"][0]), len(lines["lead"][0])
    return TracedFlank(
        DeviationGrid(u, v, _UM * deviation, "mm", "mm"),
        profiles,
        leads,
        mismatch,
        _assumed(profiles, leads, chosen, common),
    )


def _assumed(profiles: int, leads: int, chosen: Sequence[Trace], common: bool) -> tuple[str, ...]:
    told = []
    if profiles == 1:
        told.append("the profile is the same everywhere along the face, but for a shift along the lead")
    else:
        told.append("between profiles, and beyond the outermost, deviations are blended linearly or held")
    if common:
        told.append("all traces have the same zero")
    elif leads:
        told.append("each chart's zero is free: traces are shifted to agree at their crossings")
    else:
        told.append("no lead was measured: the profiles' mean is the same along the face")
    teeth = len({one.tooth for one in chosen})
    if teeth > 1:
        told.append(f"{teeth} teeth were measured and are averaged")
    told.append("beyond the measured range of a trace its last value goes on")
    return tuple(told)


def _chosen(traces: Sequence[Trace], flank: str | None, tooth: int | None) -> list[Trace]:
    there = {one.flank for one in traces}
    if flank is None and len(there) > 1:
        raise SceneError.of("flank", None, one_of(FLANKS), "the file has both: say which bears the load")
    chosen = [one for one in traces if flank in (None, one.flank) and tooth in (None, one.tooth)]
    if not any(one.kind == "profile" for one in chosen):
        teeth = ", ".join(str(one) for one in sorted({one.tooth for one in traces}))
        what = f"no profile of the {flank or 'measured'} flank" + (f" of tooth {tooth}" if tooth is not None else "")
        raise SceneError.of(
            "traces", what, f"one profile or more; teeth: {teeth or 'none'}", "choose what was measured"
        )
    return chosen


def _check(traces: Sequence[Trace], nominal: NominalFlank) -> None:
    """Refuse traces that cannot be those of the flank."""
    low, high = nominal.face_ends
    root, tip = nominal.limits(np.array([low]))
    limits = 2.0 * nominal.place(np.array([low, low]), np.array([root[0], tip[0]]))[1]
    small, large, width = float(limits.min()), float(limits.max()), high - low
    problems = []
    for one in traces:
        name = f"{one.kind} of tooth {one.tooth}, {one.flank}"
        values = np.concatenate([one.diameter, one.z, one.deviation])
        if len(one.deviation) < _LEAST or not np.all(np.isfinite(values)):
            found = f"{len(one.deviation)} points" if np.all(np.isfinite(values)) else "numbers that are not finite"
            problems.append(Problem(name, found, f"{_LEAST} finite points or more", "measure or export it again"))
            continue
        if np.abs(one.deviation).max() > _GREATEST:
            found = f"a deviation of {np.abs(one.deviation).max():g} um"
            problems.append(Problem(name, found, f"at most {_GREATEST:g} um", "check the units"))
        middle = float(np.median(one.diameter))
        if not small - 0.1 * (large - small) <= middle <= large + 0.1 * (large - small):
            found, allowed = f"a diameter of {middle:g} mm", f"on the flank, {small:.4g} to {large:.4g} mm"
            problems.append(Problem(name, found, allowed, "check the body, and that it is a diameter in mm"))
        if one.z.min() < -0.05 * width or one.z.max() > 1.05 * width:
            found, allowed = f"z from {one.z.min():g} to {one.z.max():g} mm", f"on the face, 0 to {width:g} mm"
            problems.append(Problem(name, found, allowed, "count z from the lower end of the face"))
    if problems:
        raise SceneError(problems, "traces")


def _profile_of_diameter(nominal: NominalFlank) -> Callable[[FloatArray], FloatArray]:
    """Function from diameters to profile coordinates, both [mm]."""
    middle = 0.5 * sum(nominal.face_ends)
    root, tip = (float(value[0]) for value in nominal.limits(np.array([middle])))
    beyond = 0.1 * (tip - root)
    profile = np.linspace(root - beyond, tip + beyond, _SAMPLES)
    diameter = 2.0 * nominal.place(np.full(_SAMPLES, middle), profile)[1]
    order = np.argsort(diameter)
    return lambda wanted: np.asarray(np.interp(wanted, diameter[order], profile[order]))


def _read(place: FloatArray, deviation: FloatArray, wanted: FloatArray) -> FloatArray:
    """Deviations at wanted, even places: linear between the means of what lies about each, and the trace's ends."""
    order = np.argsort(place)
    place, deviation = place[order], deviation[order]
    step = wanted[1] - wanted[0]
    _, cell, count = np.unique(np.round((place - wanted[0]) / step), return_inverse=True, return_counts=True)
    means = [np.bincount(cell, values) / count for values in (place, deviation)]
    at, values = (
        np.concatenate([own[:1], mean[1:-1], own[-1:]]) for own, mean in zip((place, deviation), means, strict=True)
    )
    return np.asarray(np.interp(wanted, at, values))


def _merged(lines: list[tuple[float, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Places and values of lines, those at one place averaged without their zeros; in the order of the places."""
    groups: list[tuple[list[float], list[FloatArray]]] = []
    for place, values in sorted(lines, key=lambda line: line[0]):
        if groups and place - groups[-1][0][-1] < _SAME:
            groups[-1][0].append(place)
            groups[-1][1].append(values)
        else:
            groups.append(([place], [values]))
    places = np.array([np.mean(at) for at, _ in groups])
    return places, np.array([np.mean(values, axis=0) for _, values in groups])


def _surface(
    at: tuple[FloatArray, FloatArray],
    profile_lines: tuple[FloatArray, FloatArray],
    lead_lines: tuple[FloatArray, FloatArray],
    common: bool,
) -> tuple[FloatArray, float]:
    """Deviations (u, v) by blending, and the greatest mismatch at the crossings."""
    (u, v), (at_v, profiles), (at_u, leads) = at, profile_lines, lead_lines
    along = _blending(at_v, v)  # (v, profiles)
    if not len(at_u):
        level = profiles.mean(axis=1, keepdims=True)
        if not common:
            profiles = profiles - level + level[0]  # the first one's zero is kept
        return profiles.T @ along.T, 0.0
    across = _blending(at_u, u)  # (u, leads)
    of_profiles = np.array([np.interp(at_u, u, one) for one in profiles])  # (profiles, leads)
    of_leads = np.array([np.interp(at_v, v, one) for one in leads]).T
    if not common:
        shift, back = _zeros(of_leads - of_profiles)
        profiles, leads = profiles + shift[:, None], leads + back[:, None]
        of_profiles, of_leads = of_profiles + shift[:, None], of_leads + back
    crossings = 0.5 * (of_profiles + of_leads)
    surface = profiles.T @ along.T + across @ leads - across @ crossings.T @ along.T
    return np.asarray(surface), float(np.abs(of_profiles - of_leads).max())


def _zeros(apart: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Zeros a of profiles and b of leads for which P + a = L + b at every crossing, the first profile's kept.

    Parameters
    ----------
    apart : (profiles, leads) array
        L - P.
    """
    rows, columns = apart.shape
    matrix = np.zeros((rows * columns + 1, rows + columns))
    place = np.arange(rows * columns)
    matrix[place, place // columns], matrix[place, rows + place % columns] = 1.0, -1.0
    matrix[-1, 0] = 1.0
    found = np.linalg.lstsq(matrix, np.append(apart.ravel(), 0.0), rcond=None)[0]
    return found[:rows], found[rows:]


def _blending(places: FloatArray, wanted: FloatArray) -> FloatArray:
    """Weights (wanted, places): linear between places, held beyond the outermost."""
    return np.stack([np.interp(wanted, places, one) for one in np.eye(len(places))], axis=1)

"""Quantities by which the statements of a published study are tested, by name."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np

from semiwear.meshing.flank_pair import BODIES
from semiwear.report.evidence import Evidence, NotComparable
from semiwear.report.markup import figure_text
from semiwear.results.schema import Zone

Measure = Callable[[Evidence], SimpleNamespace]

MEASURES: dict[str, Measure] = {}
"""Functions that compute these quantities; they raise `NotComparable` if the result does not hold their inputs."""

_SIDES = {"root": Zone.ROOT, "addendum": Zone.ADDENDUM}


def _measure(function: Measure) -> Measure:
    MEASURES[function.__name__] = function
    return function


@_measure
def printed(evidence: Evidence) -> SimpleNamespace:
    """Ratios of published figures."""
    wear, values = evidence.paper["wear"], evidence.paper["at_60_um"]
    engagements, depth = np.asarray(wear["engagements_1e10"], dtype=float), wear["control_depth_um"][-1]
    increments = np.diff(engagements, prepend=0.0)
    constant = float(engagements[-1] * 1e10 * wear["coefficient_mm2_per_N"])
    return SimpleNamespace(
        root_over_depth=values["max_wear_root_um"] / depth,
        addendum_over_depth=values["max_wear_addendum_um"] / depth,
        first_increment=increments[0],
        last_increment=increments[-1],
        shrinking=int((np.diff(increments) <= 0).sum()),
        all_over_first=engagements[-1] / engagements[0],
        first_share=engagements[0] / engagements[-1],
        wear_constant=constant,
        wearing_load=depth * 1e-3 / constant,
    )


# ---------------------------------------------------------------------- wear


@_measure
def zone_wear(evidence: Evidence) -> SimpleNamespace:
    """Greatest wear of each zone at the last wear step, and the least of the pitch cone's band [um]."""
    depth, zone = evidence.gear_flank("wear_depth"), evidence.gear_flank("zone")
    pitch = zone == Zone.PITCH
    greatest = {name: evidence.history(f"wear_depth_max_{name}")[-1] for name in ("root", "addendum", "pitch")}
    return SimpleNamespace(**greatest, least_pitch=float(depth[pitch].min()) if pitch.any() else 0.0)


@_measure
def zone_wear_at_depth(evidence: Evidence) -> SimpleNamespace:
    """Greatest wear of each zone at the published depth of the control point [um]."""
    at = {name: evidence.at_last_depth(f"wear_depth_max_{name}") for name in ("root", "addendum", "pitch")}
    over = {f"{name}_over_depth": at[name] / evidence.last_depth for name in _SIDES}
    return SimpleNamespace(**at, **over, pitch_over_root=at["pitch"] / at["root"])


@_measure
def sliding(evidence: Evidence) -> SimpleNamespace:
    """Greatest specific sliding of each side of the gear's active flank."""
    specific, active = np.abs(evidence.gear_flank("specific_sliding")), evidence.gear_flank("active") > 0
    zone = evidence.gear_flank("zone")
    return SimpleNamespace(
        **{name: float(np.max(specific, where=(zone == side) & active, initial=0.0)) for name, side in _SIDES.items()}
    )


@_measure
def across_width(evidence: Evidence) -> SimpleNamespace:
    """Parabola through the deepest root-side wear of each station along the face."""
    depth, zone, radius = (evidence.gear_flank(name) for name in ("wear_depth", "zone", "flank_radius"))
    at_root = np.where(zone == Zone.ROOT, depth, 0.0).max(axis=0)
    stations = (zone == Zone.ROOT).any(axis=0)
    if stations.sum() < 4:
        raise NotComparable("the root side has fewer than four stations along the face")
    face = radius.mean(axis=0)[stations]
    found = _parabola(face, at_root[stations])
    found.inner, found.outer = face.min(), face.max()
    found.end = "top" if found.curvature < 0 else "lowest point"
    found.deepest = face[at_root[stations].argmax()]
    return found


@_measure
def along_height(evidence: Evidence) -> SimpleNamespace:
    """Parabola through the wear along the tooth height, at the station nearest to mid-face that has all zones."""
    depth, zone, height, radius = (
        evidence.gear_flank(name) for name in ("wear_depth", "zone", "flank_height", "flank_radius")
    )
    complete = np.all([(zone == side).any(axis=0) for side in Zone], axis=0)
    if not complete.any():
        raise NotComparable("no station along the face has root, pitch cone and addendum")
    face = radius.mean(axis=0)
    distance = np.where(complete, np.abs(face - (face.min() + face.max()) / 2), np.inf)
    station = int(distance.argmin())
    found = _parabola(height[:, station], depth[:, station])
    found.radius = face[station]
    found.root, found.pitch, found.addendum = (float(depth[zone[:, station] == side, station].max()) for side in Zone)
    return found


def _parabola(position: np.ndarray, values: np.ndarray) -> SimpleNamespace:
    """Second-order coefficient, position of the extremum and R squared of a fitted parabola."""
    middle = position.mean()
    second, first, constant = np.polyfit(position - middle, values, 2)
    spread = float(((values - values.mean()) ** 2).sum())
    rest = float(((np.polyval([second, first, constant], position - middle) - values) ** 2).sum())
    return SimpleNamespace(
        curvature=float(second),
        opens="downwards" if second < 0 else "upwards",
        extremum=float(middle - first / (2 * second)) if second != 0 else np.inf,
        fit=1.0 - rest / spread if spread > 0 else 0.0,
    )


@_measure
def sliding_at_pitch(evidence: Evidence) -> SimpleNamespace:
    """Sliding distance at roll position 0 over its greatest value."""
    distance = evidence.get("engagement", "sliding_distance").sel(body="gear").isel(wear_step=-1)
    known = np.isfinite(distance.values)  # unknown where only edges carry load
    values, roll = distance.values[known], distance["roll_position"].values[known]
    if not (values > 0.0).any():
        raise NotComparable("the flanks do not slide at any roll position")
    return SimpleNamespace(share=float(np.interp(0.0, roll, values)) / float(values.max()))


# ---------------------------------------------------------------------- meshes


@_measure
def engagements(evidence: Evidence) -> SimpleNamespace:
    """Meshes for each of the published depth steps in this result, and their course against the published one."""
    wear = evidence.paper["wear"]
    depths = np.asarray(wear["control_depth_um"], dtype=float)
    published = np.asarray(wear["engagements_1e10"], dtype=float)
    own = np.array([evidence.at_depth(evidence.meshes, depth) for depth in depths])
    increments = np.diff(own, prepend=0.0)
    difference = own / own[-1] - published / published[-1]
    worst = int(np.abs(difference).argmax())
    return SimpleNamespace(
        first=increments[0],
        last=increments[-1],
        last_over_first=increments[-1] / increments[0],
        shrinking=int((np.diff(increments) <= 0).sum()),
        changes=increments.size - 1,
        difference=difference[worst],
        difference_size=abs(difference[worst]),
        at_depth=depths[worst],
        all_over_first=own[-1] / own[0],
        first_share=own[0] / own[-1],
    )


@_measure
def wear_constant(evidence: Evidence) -> SimpleNamespace:
    """Wear coefficient times meshes [mm^2/N] for the published depth."""
    here = evidence.at_depth(evidence.meshes, evidence.last_depth) * evidence.wear_coefficient()
    factor = printed(evidence).wear_constant / here
    load = evidence.last_depth * 1e-3 / here
    return SimpleNamespace(here=here, factor=factor, deviation=abs(factor - 1.0), wearing_load=load)


# ---------------------------------------------------------------------- load, stress and transmission error


@_measure
def share(evidence: Evidence) -> SimpleNamespace:
    """Greatest load share over the wear steps."""
    values = evidence.history("load_share_max")
    return SimpleNamespace(unworn=values[0], first=values[1], last=values[-1], greatest=values.max())


@_measure
def greatest_load_share(evidence: Evidence) -> SimpleNamespace:
    """Roll position of the greatest load share at the last wear step."""
    return _roll_of_greatest(evidence, "load_share", "")


@_measure
def greatest_root_stress(evidence: Evidence) -> SimpleNamespace:
    """Roll positions of the greatest root stresses at the last wear step."""
    return _roll_of_greatest(evidence, "root_stress", *BODIES)


def _roll_of_greatest(evidence: Evidence, name: str, *bodies: str) -> SimpleNamespace:
    array = evidence.get("engagement", name).isel(wear_step=-1)
    roll = array["roll_position"].values
    middles, places, at_pitch = [], [], []
    for body in bodies:
        values = (array.sel(body=body) if body else array).values
        if not np.isfinite(values).all():
            raise NotComparable(f"/engagement/{name} is missing at some roll positions")
        # on a plateau: the mean of the roll positions within 1 % of the greatest value
        middles.append(float(roll[values >= 0.99 * values.max()].mean()))
        places.append(f"{body} at roll position {figure_text(round(middles[-1], 2), 2)}".strip())
        at_pitch.append(f"{body} {np.interp(0.0, roll, values) / values.max():.0%}".strip())
    return SimpleNamespace(
        distance=max(abs(middle) for middle in middles), places=", ".join(places), at_pitch=", ".join(at_pitch)
    )


@_measure
def edge_pressure(evidence: Evidence) -> SimpleNamespace:
    """Greatest pressure on the rounded edges [MPa]."""
    edge = evidence.get("engagement", "contact_pressure_max_edge").max("roll_position").values
    return SimpleNamespace(unworn=edge[0], last=edge[-1])


@_measure
def loaded_length(evidence: Evidence) -> SimpleNamespace:
    """Loaded length along the face at the roll position of a body's greatest root stress [mm]."""
    stress, load = evidence.get("engagement", "root_stress"), evidence.get("engagement", "line_load")
    face = load["face"].values
    spacing = float(face[-1] - face[0]) / max(face.size - 1, 1)
    found = {}
    for body in BODIES:
        for when, step in (("unworn", 0), ("last", -1)):
            roll = int(stress.sel(body=body).isel(wear_step=step).values.argmax())
            loaded = load.isel(wear_step=step, roll_position=roll).values > 0.0
            found[f"{body}_{when}"] = float(loaded.sum()) * spacing
    return SimpleNamespace(**found)


@_measure
def root_stress(evidence: Evidence) -> SimpleNamespace:
    """Greatest root stress at the published depth [MPa]."""
    return SimpleNamespace(**{body: evidence.at_last_depth("root_stress_max", body) for body in BODIES})


@_measure
def root_stress_ratio(evidence: Evidence) -> SimpleNamespace:
    """Greatest root stress of the pinion over that of the gear, at all wear steps."""
    ratio = np.divide(*(evidence.history("root_stress_max", body) for body in BODIES))
    return SimpleNamespace(least=ratio.min(), greatest=ratio.max())


@_measure
def fitting_torque(evidence: Evidence) -> SimpleNamespace:
    """Torque for the published root stress if stress were proportional to torque [N m]."""
    torque, stress = evidence.scene.get("operation", {}).get("pinion_torque_Nm"), root_stress(evidence)
    if not isinstance(torque, int | float):
        raise NotComparable("the scene has no single torque")
    values = evidence.paper["at_60_um"]
    scaled = {body: torque * values[f"root_bending_stress_{body}_MPa"] / getattr(stress, body) for body in BODIES}
    return SimpleNamespace(scene=torque, **scaled)


@_measure
def transmission_error(evidence: Evidence) -> SimpleNamespace:
    """Mean and amplitude of the loaded transmission error at the published depth and unworn [arcsec]."""
    found = {}
    for name in ("mean", "amplitude"):
        found[name] = evidence.at_last_depth(f"transmission_error_{name}")
        found[f"unworn_{name}"] = evidence.history(f"transmission_error_{name}")[0]
    rigid = evidence.get("mesh_cycle", "transmission_error_unloaded").values[-1].mean()
    published = evidence.paper["at_60_um"]["transmission_error_mean_arcsec"]
    return SimpleNamespace(**found, rigid=rigid, published_less_rigid=published - rigid)

"""Statements of the seed paper on wear, sliding and engagements, and the rules that test them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from semiwear.report.comparison import Comparison, Evidence, NotComparable, Outcome
from semiwear.report.markup import figure_text
from semiwear.report.paper_rules import NOT_STATED, number, within
from semiwear.results.schema import Zone

__all__ = ["WEAR"]

WEAR_TOLERANCE = 0.25
NEAR_ZERO_SHARE = 0.05
SLIDING_SHARE = 0.10
SHAPE_TOLERANCE = 0.05


def _deepest_at_root(evidence: Evidence) -> Outcome:
    root, addendum, pitch = (evidence.history(f"wear_depth_max_{zone}")[-1] for zone in ("root", "addendum", "pitch"))
    ours = f"root {root:.3g} µm, addendum {addendum:.3g} µm, pitch cone {pitch:.3g} µm"
    sliding, active, zone = (
        np.abs(evidence.gear_flank("specific_sliding")),
        evidence.gear_flank("active"),
        evidence.gear_flank("zone"),
    )
    reached = {
        side: float(np.max(sliding, where=(zone == side) & (active > 0), initial=0.0))
        for side in (Zone.ROOT, Zone.ADDENDUM)
    }
    why = (
        "Archard's law wears by line load times specific sliding, and the gear's specific sliding reaches "
        f"{reached[Zone.ROOT]:.2f} at the root and {reached[Zone.ADDENDUM]:.2f} at the addendum on the active "
        "flank: a gear with so many teeth is nearly a rack, on which both sides slide alike. "
    )
    return Outcome(ours, bool(root > addendum > pitch), why + NOT_STATED)


def _wear_value(zone: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        published = evidence.paper["at_60_um"][f"max_wear_{zone}_um"]
        value = evidence.at_last_depth(f"wear_depth_max_{zone}")
        why = (
            f"At the same {evidence.last_depth:g} µm at the control point the greatest wear here is "
            f"{value / evidence.last_depth:.2f} times that depth, in the paper "
            f"{published / evidence.last_depth:.2f} times. The paper does not say where its sixth contact "
            f"point lies, and the ratio hangs on that place. {NOT_STATED}"
        )
        return number(published, value, WEAR_TOLERANCE, "µm", why)

    return judge


def _pitch_near_zero(evidence: Evidence) -> Outcome:
    pitch = evidence.at_last_depth("wear_depth_max_pitch")
    root = evidence.at_last_depth("wear_depth_max_root")
    wear, zone = evidence.gear_flank("wear_depth"), evidence.gear_flank("zone")
    least = float(wear[zone == Zone.PITCH].min()) if (zone == Zone.PITCH).any() else 0.0
    why = (
        "The value here is the greatest over a band as wide as the contact, whose borders slide already; "
        f"the least within the band is {least:.2g} µm."
    )
    return Outcome(f"{pitch:.3g} µm, {pitch / root:.1%} of the root's", pitch <= NEAR_ZERO_SHARE * root, why)


def _across_width(evidence: Evidence) -> Outcome:
    wear, zone, radius = (evidence.gear_flank(name) for name in ("wear_depth", "zone", "flank_radius"))
    at_root = np.where(zone == Zone.ROOT, wear, 0.0).max(axis=0)
    stations = (zone == Zone.ROOT).any(axis=0)
    if stations.sum() < 4:
        raise NotComparable("the root side has fewer than four stations along the face")
    face = radius.mean(axis=0)[stations]
    curvature, top, fit = _parabola(face, at_root[stations])
    inside = bool(face.min() < top < face.max())
    place = f"its {'top' if curvature < 0 else 'lowest point'} at radius {top:.0f} mm"
    ours = f"fitted parabola opens {'downwards' if curvature < 0 else 'upwards'}, {place}, R² = {fit:.2f}; "
    ours += f"the deepest root-side wear is at radius {face[at_root[stations].argmax()]:.0f} mm"
    why = (
        "The pitch cone crosses the whole tooth, so the root side takes the full height at the inner end "
        "and vanishes at the outer end; the course of wear over the width is as lopsided as that side."
    )
    return Outcome(ours, curvature < 0 and inside, why)


def _along_height(evidence: Evidence) -> Outcome:
    wear, zone, height, radius = (
        evidence.gear_flank(name) for name in ("wear_depth", "zone", "flank_height", "flank_radius")
    )
    station = _middle_station(zone, radius)
    root, pitch, addendum = (float(wear[zone[:, station] == side, station].max()) for side in Zone)
    curvature, _, fit = _parabola(height[:, station], wear[:, station])
    ours = (
        f"at radius {radius[:, station].mean():.0f} mm: root {root:.3g} µm, pitch cone {pitch:.3g} µm, "
        f"addendum {addendum:.3g} µm; fitted parabola opens {'upwards' if curvature > 0 else 'downwards'}, "
        f"R² = {fit:.2f}"
    )
    why = (
        "The line is taken at mid-face, where the pitch cone lies below the pitch plane and leaves less "
        "of the tooth to the root side than to the addendum; the paper does not say where its line runs."
    )
    return Outcome(ours, curvature > 0 and root > addendum > pitch, why)


def _middle_station(zone: np.ndarray, radius: np.ndarray) -> int:
    """Station nearest to mid-face that has all three zones."""
    complete = np.all([(zone == side).any(axis=0) for side in Zone], axis=0)
    if not complete.any():
        raise NotComparable("no station along the face has root, pitch cone and addendum")
    face = radius.mean(axis=0)
    distance = np.where(complete, np.abs(face - (face.min() + face.max()) / 2), np.inf)
    return int(distance.argmin())


def _parabola(position: np.ndarray, values: np.ndarray) -> tuple[float, float, float]:
    """Second-order coefficient, place of the extremum and R squared of a fitted parabola."""
    middle = position.mean()
    second, first, constant = np.polyfit(position - middle, values, 2)
    spread = float(((values - values.mean()) ** 2).sum())
    rest = float(((np.polyval([second, first, constant], position - middle) - values) ** 2).sum())
    extremum = middle - first / (2 * second) if second != 0 else np.inf
    return float(second), float(extremum), 1.0 - rest / spread if spread > 0 else 0.0


def _sliding_at_pitch(evidence: Evidence) -> Outcome:
    sliding = evidence.get("engagement", "sliding_distance").sel(body="gear").isel(wear_step=-1)
    told = np.isfinite(sliding.values)  # nothing is told where edges alone bear
    values, roll = sliding.values[told], sliding["roll_position"].values[told]
    if values.size == 0:
        return Outcome("missing", False, "At no roll position does a pair bear on its flanks.")
    share = float(np.interp(0.0, roll, values)) / float(values.max())
    why = "Zero sliding is met at the pitch point alone; the place of greatest pressure is beside it."
    return Outcome(f"{share:.1%} of the greatest sliding distance", share <= SLIDING_SHARE, why)


# ---------------------------------------------------------------------- meshes


def _increments(evidence: Evidence) -> np.ndarray:
    """Meshes that each of the paper's depth steps takes here."""
    depths = np.asarray(evidence.paper["wear"]["control_depth_um"], dtype=float)
    return np.diff([0.0, *(evidence.at_depth(evidence.meshes, depth) for depth in depths)])


def _steps_grow(evidence: Evidence) -> Outcome:
    ours = _increments(evidence)
    theirs = np.diff([0.0, *evidence.paper["wear"]["engagements_1e10"]])
    shrinking = int((np.diff(ours) <= 0).sum())
    text = (
        f"first step {figure_text(ours[0])} meshes, last step {figure_text(ours[-1])}, "
        f"{ours[-1] / ours[0]:.2f} times as many; {shrinking} of {ours.size - 1} steps take no more than "
        f"the step before (in the paper's own numbers {int((np.diff(theirs) <= 0).sum())}, although its "
        "text says none)"
    )
    why = "Here the control point keeps or gains load as it wears; the paper does not say where its point lies."
    return Outcome(text, bool(ours[-1] > ours[0]), why)


def _shape_of_engagements(evidence: Evidence) -> Outcome:
    theirs = np.asarray(evidence.paper["wear"]["engagements_1e10"], dtype=float)
    ours = np.cumsum(_increments(evidence))
    deviation = ours / ours[-1] - theirs / theirs[-1]
    worst = int(np.abs(deviation).argmax())
    depth = evidence.paper["wear"]["control_depth_um"][worst]
    why = (
        f"All steps together take {ours[-1] / ours[0]:.1f} times the meshes of the first here, "
        f"{theirs[-1] / theirs[0]:.1f} times in the paper, whose first step is "
        f"{theirs[0] / theirs[-1]:.1%} of its whole life against {ours[0] / ours[-1]:.1%} here."
    )
    text = f"greatest difference {deviation[worst]:+.3f} at {depth:g} µm"
    return Outcome(text, bool(abs(deviation[worst]) <= SHAPE_TOLERANCE), why)


def _factor_of_engagements(evidence: Evidence) -> Outcome:
    paper = evidence.paper["wear"]
    theirs = paper["engagements_1e10"][-1] * 1e10 * paper["coefficient_mm2_per_N"]
    ours = evidence.at_depth(evidence.meshes, evidence.last_depth) * evidence.wear_coefficient()
    load = {name: evidence.last_depth * 1e-3 / product for name, product in (("paper", theirs), ("here", ours))}
    factor = theirs / ours
    why = (
        f"By Archard's law the paper's meshes leave {load['paper']:.2f} N/mm for line load times specific "
        f"sliding at the control point, here it is {load['here']:.0f} N/mm; a pinion at about 1600 N m, "
        "which the paper's root stress asks for, has 100 to 200 N/mm. The paper's product of wear "
        "coefficient and engagements is thus usable only up to this factor; its course over the steps is "
        "not touched by it."
    )
    here, there = figure_text(ours, 3), figure_text(theirs, 3)
    text = f"{here} mm²/N against the paper's {there} mm²/N: a factor of {factor:.3g}"
    return Outcome(text, abs(factor - 1) <= WEAR_TOLERANCE, why)


WEAR: tuple[Comparison, ...] = (
    Comparison(
        "wear_map",
        "Wear is deepest at the tooth root, smaller near the addendum, almost zero at the pitch cone.",
        "Agrees if root > addendum > pitch cone at the last step.",
        _deepest_at_root,
    ),
    Comparison(
        "wear_map",
        "Greatest wear at the root about {max_wear_root_um} µm, with {depth} µm at the control point.",
        within(WEAR_TOLERANCE),
        _wear_value("root"),
    ),
    Comparison(
        "wear_map",
        "Greatest wear near the addendum about {max_wear_addendum_um} µm.",
        within(WEAR_TOLERANCE),
        _wear_value("addendum"),
    ),
    Comparison(
        "wear_map",
        "Wear at the pitch cone almost zero.",
        f"Agrees if the greatest wear of the pitch cone's band is at most {NEAR_ZERO_SHARE:.0%} of the root's.",
        _pitch_near_zero,
    ),
    Comparison(
        "wear_profiles",
        "Along the tooth width wear is a convex parabola: largest inside the width.",
        "Agrees if a parabola fitted to the greatest root-side wear of each station opens downwards with "
        "its top inside the width.",
        _across_width,
    ),
    Comparison(
        "wear_profiles",
        "Along the tooth height wear is a concave parabola: large at the root, near zero at the pitch "
        "cone, small at the addendum.",
        "Agrees if, on the line nearest to mid-face, a fitted parabola opens upwards and root > addendum "
        "> pitch cone.",
        _along_height,
    ),
    Comparison(
        "sliding_along_path",
        "Relative sliding is close to zero at the pitch cone.",
        f"Agrees if the gear's sliding distance at roll position 0 is at most {SLIDING_SHARE:.0%} of the greatest.",
        _sliding_at_pitch,
    ),
    Comparison(
        "meshes_against_depth",
        "Each further 5 µm takes more engagements: {first_increment:.1f}·10¹⁰ for the first, "
        "{last_increment:.1f}·10¹⁰ for the last.",
        "Agrees if the last step takes more meshes than the first.",
        _steps_grow,
    ),
    Comparison(
        "meshes_against_depth",
        "Course of the engagements over the depth, each divided by the last.",
        f"Agrees if no step differs by more than {SHAPE_TOLERANCE:g}.",
        _shape_of_engagements,
    ),
    Comparison(
        "meshes_against_depth",
        "{last_engagements}·10¹⁰ engagements for {depth} µm, with a wear coefficient of 1·10⁻¹³ mm²/N.",
        f"Agrees if wear coefficient times meshes is within {WEAR_TOLERANCE:.0%}.",
        _factor_of_engagements,
    ),
)

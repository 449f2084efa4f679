"""Statements of the seed paper on load share, stress and transmission error, and the rules that test them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from semiwear.report.comparison import Comparison, Evidence, Outcome
from semiwear.report.markup import figure_text
from semiwear.report.paper_rules import NOT_STATED, both, number, within
from semiwear.report.trends import LEVEL_SHARE, Trend, falls, levels, rises

__all__ = ["LEVEL_DEPTH", "LOAD"]

STRESS_TOLERANCE = 0.10
ERROR_TOLERANCE = 0.10
MIDDLE_OF_ENGAGEMENT = 0.25
LEVEL_DEPTH = 40.0  # um at the control point, where the paper has 43.2e10 engagements


def _rises(name: str, body: str | None, units: str, why: str, size: bool = False) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        values = evidence.history(name, body)
        trend = rises(np.abs(values) if size else values, units)
        return Outcome(trend.text, trend.holds, why)

    return judge


def _root_stress_rises(body: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        trend = rises(evidence.history("root_stress_max", body), "MPa")
        share = evidence.history("load_share_max")
        lengths = [_loaded_length(evidence, body, step) for step in (0, -1)]
        why = (
            "Root stress follows the greatest load share, which rises at first "
            f"({share[0]:.2f} unworn, {share.max():.2f} at most, {share[-1]:.2f} at last), and the length of face "
            "that carries it: where the stress is greatest, the loaded lines lengthen from "
            f"{lengths[0]:.0f} to {lengths[1]:.0f} mm as wear takes the crown off the contact."
        )
        return Outcome(trend.text, trend.holds, why)

    return judge


def _loaded_length(evidence: Evidence, body: str, step: int) -> float:
    """Length of face that is loaded where a body's root stress is greatest [mm]."""
    roll = int(evidence.get("engagement", "root_stress").sel(body=body).isel(wear_step=step).values.argmax())
    load = evidence.get("engagement", "line_load").isel(wear_step=step, roll_position=roll)
    face = load["face"].values
    return float((load.values > 0.0).sum() * (face[-1] - face[0]) / max(face.size - 1, 1))


def _falls_then_levels(name: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        values = evidence.history(name)
        share = evidence.history("load_share_max")
        edge = evidence.get("engagement", "contact_pressure_max_edge").max("roll_position").values
        why = (
            "Counted here are contacts that no edge cuts off; the greatest of them first lies beside the pitch "
            f"band, where the load share grows from {share[0]:.2f} to {share[1]:.2f} in the first step, before wear "
            "unloads the side. The paper's values include edge contact: on the rounded edges the raw peak goes "
            f"from {edge[0]:.0f} to {edge[-1]:.0f} MPa here, and depends on their radius."
        )
        return both(falls(values, "MPa"), levels(evidence.meshes, values), why)

    return judge


def _stress_value(body: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        published = evidence.paper["at_60_um"][f"root_bending_stress_{body}_MPa"]
        value = evidence.at_last_depth("root_stress_max", body)
        torque = evidence.scene.get("operation", {}).get("pinion_torque_Nm")
        scaled = (
            f" Root stress is nearly proportional to torque: {torque * published / value:.0f} N m instead "
            f"of {torque:g} N m would bring the published value."
            if isinstance(torque, int | float)
            else ""
        )
        return number(published, value, STRESS_TOLERANCE, "MPa", NOT_STATED + scaled)

    return judge


def _load_share(evidence: Evidence) -> Outcome:
    values = evidence.history("load_share_max")
    first, second = _rises_before(evidence, values, ""), _level_after(evidence, values)
    return both(first, second, f"The paper gives no values, only the course. {NOT_STATED}")


def _pitch_pressure(evidence: Evidence) -> Outcome:
    values = evidence.history("contact_pressure_pitch")
    first, second = _rises_before(evidence, values, "MPa"), _level_after(evidence, values)
    why = (
        "The pressure at the pitch cone follows the load that the worn sides shed; it turns where they "
        f"stop shedding, and that moment hangs on the load. {NOT_STATED}"
    )
    return both(first, second, why)


def _rises_before(evidence: Evidence, values: np.ndarray, units: str) -> Trend:
    trend = rises(evidence.until(values, LEVEL_DEPTH), units)
    return Trend(trend.holds, f"up to {LEVEL_DEPTH:g} µm: {trend.text}")


def _level_after(evidence: Evidence, values: np.ndarray) -> Trend:
    turn, end = (evidence.at_depth(values, depth) for depth in (LEVEL_DEPTH, evidence.last_depth))
    spread = float(np.ptp(values))
    share = (end - turn) / spread if spread > 0 else 0.0
    text = f"from {LEVEL_DEPTH:g} to {evidence.last_depth:g} µm it changes by {share:+.0%} of its whole range"
    return Trend(abs(share) < LEVEL_SHARE, text)


def _in_the_middle(name: str, *bodies: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        array = evidence.get("engagement", name).isel(wear_step=-1)
        roll = array["roll_position"].values
        middles, places, at_pitch = [], [], []
        for body in bodies or ("",):
            values = (array.sel(body=body) if body else array).values
            # A plateau has one middle: that of all places within 1 % of the greatest value.
            middles.append(float(roll[values >= 0.99 * values.max()].mean()))
            places.append(f"{body} at roll position {figure_text(round(middles[-1], 2), 2)}".strip())
            at_pitch.append(f"{body} {np.interp(0.0, roll, values) / values.max():.0%}".strip())
        why = f"At the pitch point itself it is {', '.join(at_pitch)} of the greatest."
        near = all(abs(middle) <= MIDDLE_OF_ENGAGEMENT for middle in middles)
        return Outcome(", ".join(places), near, why)

    return judge


def _pinion_above_gear(evidence: Evidence) -> Outcome:
    ratio = evidence.history("root_stress_max", "pinion") / evidence.history("root_stress_max", "gear")
    why = f"The ratio is that of the root fillets and rims, of which the paper gives none. {NOT_STATED}"
    return Outcome(f"pinion over gear: {ratio.min():.2f} to {ratio.max():.2f}", bool((ratio > 1).all()), why)


def _error_value(kind: str) -> Callable[[Evidence], Outcome]:
    def judge(evidence: Evidence) -> Outcome:
        published = evidence.paper["at_60_um"][f"transmission_error_{kind}_arcsec"]
        value = evidence.at_last_depth(f"transmission_error_{kind}")
        fresh = evidence.history(f"transmission_error_{kind}")[0]
        rigid = evidence.get("mesh_cycle", "transmission_error_unloaded").values[-1].mean()
        why = f"Unworn it is {figure_text(fresh, 3)} arcsec here. "
        if kind == "mean":
            why += (
                f"Without load the mean of the worn pair is {figure_text(rigid, 3)} arcsec, the rigid part "
                f"of wear; the paper's value would leave {figure_text(published - rigid, 3)} arcsec for "
                "the load, unless it leaves that part out. "
            )
        return number(published, value, ERROR_TOLERANCE, "arcsec", why + NOT_STATED)

    return judge


_LEVEL_AFTER_RULE = (
    f"Agrees if it rises up to {LEVEL_DEPTH:g} µm at the control point and from there changes by less than "
    f"{LEVEL_SHARE:.0%} of its range."
)

LOAD: tuple[Comparison, ...] = (
    Comparison(
        "load_share",
        "The greatest load share rises up to {level_engagements}·10¹⁰ engagements, then approaches a constant.",
        _LEVEL_AFTER_RULE,
        _load_share,
    ),
    Comparison(
        "load_share",
        "The load share is greatest near the middle of the pitch cone.",
        f"Agrees if its maximum is within {MIDDLE_OF_ENGAGEMENT:g} base pitches of the pitch point.",
        _in_the_middle("load_share"),
    ),
    Comparison(
        "root_stress_history",
        "The gear's root stress rises with wear.",
        "Agrees if it rises.",
        _root_stress_rises("gear"),
    ),
    Comparison(
        "root_stress_history",
        "The pinion's root stress rises with wear.",
        "Agrees if it rises.",
        _root_stress_rises("pinion"),
    ),
    Comparison(
        "root_stress_history",
        "The pinion's root stress is always above the gear's.",
        "Agrees if it is so at every wear step.",
        _pinion_above_gear,
    ),
    Comparison(
        "root_stress_history",
        "Root stress is greatest when the contact is near the middle of the pitch cone.",
        f"Agrees if both maxima are within {MIDDLE_OF_ENGAGEMENT:g} base pitches of the pitch point.",
        _in_the_middle("root_stress", "pinion", "gear"),
    ),
    Comparison(
        "root_stress_history",
        "Gear {root_bending_stress_gear_MPa} MPa after {depth} µm at the control point.",
        within(STRESS_TOLERANCE),
        _stress_value("gear"),
    ),
    Comparison(
        "root_stress_history",
        "Pinion {root_bending_stress_pinion_MPa} MPa after {depth} µm at the control point.",
        within(STRESS_TOLERANCE),
        _stress_value("pinion"),
    ),
    Comparison(
        "contact_stress_history",
        "Contact stress at the root falls, then approaches a constant.",
        "Agrees if it falls and levels.",
        _falls_then_levels("contact_pressure_root"),
    ),
    Comparison(
        "contact_stress_history",
        "Contact stress at the addendum falls, then approaches a constant.",
        "Agrees if it falls and levels.",
        _falls_then_levels("contact_pressure_addendum"),
    ),
    Comparison(
        "contact_stress_history",
        "Contact stress at the pitch cone rises up to {level_engagements}·10¹⁰ engagements, then falls "
        "slightly and levels.",
        _LEVEL_AFTER_RULE,
        _pitch_pressure,
    ),
    Comparison(
        "transmission_error_history",
        "The size of the mean of the loaded transmission error rises.",
        "Agrees if its absolute value rises.",
        _rises(
            "transmission_error_mean",
            None,
            "arcsec",
            "Deflection and the rigid part of wear add up in the mean.",
            True,
        ),
    ),
    Comparison(
        "transmission_error_history",
        "The amplitude of the loaded transmission error rises.",
        "Agrees if it rises.",
        _rises(
            "transmission_error_amplitude",
            None,
            "arcsec",
            "A likely cause of a fall: wear first evens out the change of deflection as tooth pairs come "
            "and go, before it outgrows it.",
        ),
    ),
    Comparison(
        "transmission_error_history",
        "Mean {transmission_error_mean_arcsec} arcsec after {depth} µm at the control point.",
        within(ERROR_TOLERANCE),
        _error_value("mean"),
    ),
    Comparison(
        "transmission_error_history",
        "Amplitude {transmission_error_amplitude_arcsec} arcsec after {depth} µm at the control point.",
        within(ERROR_TOLERANCE),
        _error_value("amplitude"),
    ),
)

"""Hard cases: scenes at the limits of geometry, load and material, placements, worn and measured flanks, bare gaps.

Grids are small and teeth mostly rigid, so that an example takes a fraction of a second. The cases with names are in
`tests/unit/test_hard_scenes.py`.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from semiwear.scene import Placement, Scene
from tests.scenes import CONFORMAL, NOMINAL_TORQUE, SHARP, UNTIL_MESHES, scene_of

DERIVED = (
    "pinion_centre_mm",
    "pinion_addendum_mm",
    "gear_addendum_mm",
    "shaper_addendum_mm",
    "rack_addendum_mm",
    "shaper_tip_radius_mm",
    "rack_tip_radius_mm",
    "pinion_bore_radius_mm",
    "gear_rim_thickness_mm",
)


class Hung(AssertionError):
    """An example took longer than it may."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Stop what takes more processor time, where the platform can: another's load on the machine is no hang."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise Hung(f"no end after {seconds:g} s of processor time")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


def _power(low: float, high: float) -> st.SearchStrategy[float]:
    """Ten to a power between the two."""
    return _between(low, high).map(lambda exponent: float(10.0**exponent))


# ---- gear pairs: changes of the shipped scene


def at_the_undercut_limit() -> st.SearchStrategy[dict[str, Any]]:
    """Inner radii from a nanometre to some millimetres outside the undercut limit, and some inside it."""
    return st.one_of(_power(-6.0, 0.8), st.just(-0.1)).map(
        lambda beyond: {"gear_pair.gear_inner_radius_mm": 465.174 + beyond}
    )


def at_the_pointing_limit() -> st.SearchStrategy[dict[str, Any]]:
    """Outer radii up to the pointing limit at 569.33 mm; sharp tips, as no rounding fits on such a land."""
    return st.builds(
        lambda less, edge: {
            "gear_pair.gear_outer_radius_mm": 569.329 - less,
            "gear_pair.gear_tip_edge_radius_mm": edge,
        },
        _power(-3.0, 1.0),
        st.sampled_from([0.0, 1e-9, 1e-3, 0.02]),
    )


def pinion_tips_on_the_gear_fillet() -> st.SearchStrategy[dict[str, Any]]:
    """Pinion addenda up to where the tip meets the gear's fillet, 7.356 mm, and a little beyond."""
    return _between(6.9, 7.36).map(lambda addendum: {"gear_pair.pinion_addendum_mm": addendum})


def localised() -> st.SearchStrategy[dict[str, Any]]:
    """Shapers with many more teeth than the pinion."""
    return st.integers(30, 60).map(
        lambda teeth: {
            "gear_pair.shaper_teeth": teeth,
            "gear_pair.gear_inner_radius_mm": 495.0,
            "gear_pair.gear_outer_radius_mm": 520.0,
        }
    )


@st.composite
def tooth_numbers(draw: st.DrawFn) -> dict[str, Any]:
    """Pairs of 12 to 300 teeth of any module, every other length in proportion; few teeth are often refused."""
    pinion = draw(st.integers(12, 60))
    shaper = pinion + draw(st.integers(1, 4))
    gear = draw(st.integers(max(shaper, 20), 300))
    module = draw(_power(-0.5, 1.2))
    radius, share = 0.5 * module * gear, draw(_between(0.2, 1.0))
    edge = draw(st.sampled_from([0.0, 0.03 * module]))
    return {
        "gear_pair.pinion_teeth": pinion,
        "gear_pair.shaper_teeth": shaper,
        "gear_pair.gear_teeth": gear,
        "gear_pair.module_mm": module,
        "gear_pair.pressure_angle_deg": draw(st.sampled_from([20.0, 25.0, 30.0])),
        "gear_pair.gear_inner_radius_mm": radius * (1.0 - 0.06 * share),
        "gear_pair.gear_outer_radius_mm": radius * (1.0 + 0.1 * share),
        "gear_pair.pinion_face_width_mm": 0.16 * share * radius,
        **{f"gear_pair.{name}": None for name in DERIVED},
        **dict.fromkeys(SHARP, edge),
        "operation.pinion_torque_Nm": NOMINAL_TORQUE * (module / 6.35) ** 3,
    }


def gear_pairs() -> st.SearchStrategy[dict[str, Any]]:
    """Any of the above, the shipped pair, its sharp edges, and near-conformal flanks."""
    return st.one_of(
        st.just({}),
        st.just(SHARP),
        st.just(CONFORMAL),
        at_the_undercut_limit(),
        at_the_pointing_limit(),
        pinion_tips_on_the_gear_fillet(),
        localised(),
        tooth_numbers(),
    )


# ---- load, material, grids


def torque_factors() -> st.SearchStrategy[float]:
    """From 1e-6 to 100 times nominal; often nominal."""
    return st.one_of(st.just(1.0), _power(-6.0, 2.0))


@st.composite
def conditions(draw: st.DrawFn) -> dict[str, Any]:
    """Materials, flank, fidelity and grids."""
    changes: dict[str, Any] = {
        "numerics.fidelity": draw(st.sampled_from(["line", "line", "patch"])),
        "numerics.face_slices": draw(st.sampled_from([7, 11, 21])),
        "numerics.profile_points": draw(st.sampled_from([21, 41])),
        "operation.loaded_flank": draw(st.sampled_from(["drive", "coast"])),
    }
    if draw(st.integers(0, 4)) == 0:
        changes["material.gear.youngs_modulus_MPa"] = draw(_power(2.7, 6.17))
        changes["material.gear.poissons_ratio"] = draw(st.sampled_from([0.01, 0.3, 0.49]))
    if draw(st.integers(0, 9)) == 0:
        changes["numerics.tooth_compliance"] = "prism"
    return changes


# ---- placements


@st.composite
def hard_placements(draw: st.DrawFn, module: float = 6.35) -> Placement:
    """Errors that drive contact to heel or toe, tip or root, and on to where the flanks no longer meet."""
    size = draw(_power(-2.0, 1.0))
    shift, turn = _between(-size, size), _between(-5.0 * size, 5.0 * size)
    return Placement(
        offset_mm=draw(shift) * module / 6.35,
        axial_pinion_mm=draw(st.one_of(shift, _between(-100.0, 100.0))) * module / 6.35,
        axial_gear_mm=draw(shift) * module / 6.35,
        shaft_angle_error_mrad=draw(turn),
        pinion_slope_mrad=draw(turn),
    )


def mirrored(placement: Placement) -> Placement:
    """The placement in the mirror at x = 0, which turns drive flanks into coast flanks."""
    return replace(placement, offset_mm=-placement.offset_mm, pinion_slope_mrad=-placement.pinion_slope_mrad)


# ---- worn and measured flanks


@st.composite
def wear_maps(draw: st.DrawFn, shape: tuple[int, int]) -> np.ndarray:
    """Wear depths [um], (profile, face): even, ridges, scratches, noise, and bowls of up to some millimetres."""
    profile, face = np.linspace(0.0, 1.0, shape[0])[:, None], np.linspace(0.0, 1.0, shape[1])[None]
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["even", "ridge", "noise", "scratches", "bowl", "half"]))
    form = {
        "even": np.ones(shape),
        "ridge": np.abs(profile - random.random()) * np.ones(shape),
        "noise": random.random(shape),
        "scratches": (random.random((shape[0], 1)) < 0.05) * np.ones(shape),
        "bowl": np.exp(-(((profile - random.random()) / 0.2) ** 2) - ((face - random.random()) / 0.3) ** 2),
        # the nominal path may carry nothing
        "half": (face < random.random()) * np.ones(shape),
    }[kind]
    return draw(_power(-3.0, 3.3)) * form


@st.composite
def measured_flanks(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fractions of profile and face, and deviations there [um]: a smooth form and noise of up to some micrometres."""
    profile, face = (np.linspace(0.0, 1.0, draw(st.integers(4, most))) for most in (40, 25))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    noise = draw(_power(-2.0, 1.0)) * random.standard_normal((profile.size, face.size))
    form = draw(_between(-20.0, 20.0)) * np.outer((2.0 * profile - 1.0) ** 2, 2.0 * face - 1.0)
    return profile, face, form + noise


# ---- everything at once


@dataclass(frozen=True)
class HardCase:
    """Changes of the small scene, a placement, and the seed of a wear map that fits the grids."""

    changes: dict[str, Any]
    placement: Placement | None
    wear: np.ndarray | None

    def scene(self) -> Scene:
        """The scene; a `SceneError` where it is refused."""
        return scene_of(self.changes)


@st.composite
def hard_cases(draw: st.DrawFn) -> HardCase:
    """Any pair under any conditions, often misplaced, often worn."""
    changes = draw(gear_pairs()) | draw(conditions())
    torque = changes.get("operation.pinion_torque_Nm", NOMINAL_TORQUE)
    changes["operation.pinion_torque_Nm"] = torque * draw(torque_factors())
    placement = draw(st.one_of(st.none(), hard_placements(changes.get("gear_pair.module_mm", 6.35))))
    shape = changes["numerics.profile_points"], changes["numerics.face_slices"]
    return HardCase(changes, placement, draw(st.one_of(st.none(), wear_maps(shape))))


@st.composite
def wear_runs(draw: st.DrawFn) -> dict[str, Any]:
    """Changes for a run of one to four steps: from nothing worn to steps a thousand times too large."""
    fidelity = draw(st.sampled_from(["line", "line", "patch"]))
    bodies = draw(st.sampled_from([["gear"], ["gear"], ["pinion"], ["pinion", "gear"]]))
    mapping = (
        draw(st.sampled_from(["interpolated", "marched"])) if fidelity == "patch" and bodies == ["gear"] else None
    )
    return {
        **UNTIL_MESHES,
        "wear.coefficient_mm2_per_N": 1e-13,
        "wear.until.meshes": draw(_power(4.0, 13.0)),
        "wear.worn_bodies": bodies,
        "numerics.wear_steps": draw(st.integers(1, 4)),
        "numerics.wear_scheme": draw(st.sampled_from(["implicit", "two-stage", "explicit"])),
        "numerics.wear_mapping": mapping,
        "numerics.fidelity": fidelity,
        "numerics.face_slices": draw(st.sampled_from([7, 11])),
        "numerics.profile_points": draw(st.sampled_from([21, 41])),
        "operation.pinion_torque_Nm": NOMINAL_TORQUE * draw(st.one_of(st.just(1.0), _power(-3.0, 1.0))),
    }


# ---- bare gaps


@dataclass(frozen=True)
class LineGap:
    """Slices of several contact lines under one torque [N mm]; lengths in mm, compliance in mm/N."""

    starts: np.ndarray
    gap: np.ndarray
    curvature: np.ndarray
    arc: np.ndarray
    length: np.ndarray
    modulus: float
    torque: float
    wear_compliance: np.ndarray


@st.composite
def line_gaps(draw: st.DrawFn) -> LineGap:
    """Up to three lines with gaps from nanometres to metres: smooth, rough, stepped, or all alike."""
    counts = draw(st.lists(st.integers(1, 24), min_size=1, max_size=3))
    starts = np.concatenate([[0], np.cumsum(counts)])
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    step = draw(_power(-2.0, 1.0))
    place = np.concatenate([np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1) for count in counts])
    form = {
        "alike": np.zeros(place.size),
        "bowl": place**2,
        "rough": random.random(place.size),
        "steps": random.integers(0, 3, place.size).astype(float),
    }[draw(st.sampled_from(["alike", "bowl", "rough", "steps"]))]
    wear = draw(st.sampled_from([0.0, 1e-6, 1.0]))
    return LineGap(
        starts=starts,
        gap=draw(_power(-6.0, 3.0)) * form + draw(st.sampled_from([0.0, -5.0, 1e3])),
        curvature=np.full(place.size, draw(_power(-4.0, 0.5))),
        arc=np.concatenate([step * (np.arange(count) + 0.5) for count in counts]),
        length=np.full(place.size, step),
        modulus=draw(st.sampled_from([1.0, 1.15e5, 1e7])),
        torque=draw(_power(-4.0, 7.0)),
        wear_compliance=wear * random.random(place.size),
    )

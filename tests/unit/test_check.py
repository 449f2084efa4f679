"""Geometric limits of a scene: every limit flips where its message says, and nothing ever raises."""

import dataclasses
import re
from math import pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.check import geometric_problems
from semiwear.errors import Problem
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.scene import ControlPoint, Placement, Scene, load_scene

SHIPPED = load_scene("face_gear_25x160")
MODULE = 6.35
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")


def scene_with(**fields: float) -> Scene:
    """The shipped scene without control point, with other values in its gear pair, plain rules not applied."""
    assert SHIPPED.wear is not None
    wear = dataclasses.replace(SHIPPED.wear, control_point=None)
    pair = dataclasses.replace(SHIPPED.gear_pair, **fields)  # type: ignore[arg-type]
    return dataclasses.replace(SHIPPED, gear_pair=pair, wear=wear)


def scene_with_point(radius: float, height: float, **fields: float) -> Scene:
    scene = scene_with(**fields)
    assert scene.wear is not None
    point = ControlPoint(radius_mm=radius, height_mm=height)
    return dataclasses.replace(scene, wear=dataclasses.replace(scene.wear, control_point=point))


def problems(scene: Scene) -> dict[str, Problem]:
    found = geometric_problems(scene)
    by_field = {problem.field.removeprefix("gear_pair."): problem for problem in found}
    assert len(by_field) == len(found), "a field is named twice"
    for problem in found:
        assert NUMBER.search(problem.allowed), f"no number in: {problem}"
        assert problem.fix
        assert "cannot even be computed" not in problem.allowed
    return by_field


def limits(problem: Problem) -> list[float]:
    return [float(number) for number in NUMBER.findall(problem.allowed)]


def test_the_shipped_scene_is_sound() -> None:
    assert geometric_problems(SHIPPED) == []


UNDERCUT_PINION = {"pinion_teeth": 14, "shaper_teeth": 16, "pressure_angle_deg": 20.0, "gear_addendum_mm": 3.0}
SHORT_FACE = {"gear_inner_radius_mm": 507.0, "gear_outer_radius_mm": 509.0}

# field, a sound value, a wrong value, the limit between them, other fields
FLIPS: list[tuple[str, float, float, float, dict[str, float]]] = [
    ("gear_inner_radius_mm", 465.2, 465.1, 465.173, {}),
    # the fillet, which rises towards the inner radius, reaches a low tip plane before the tooth is undercut
    ("gear_inner_radius_mm", 469.7, 469.6, 469.672, {"gear_addendum_mm": 0.1, "gear_tip_edge_radius_mm": 0.0}),
    ("gear_outer_radius_mm", 569.3, 569.4, 569.325, {"gear_tip_edge_radius_mm": 0.0}),
    # pointed at the pitch radius already
    ("gear_addendum_mm", 10.7, 10.8, 10.712, SHORT_FACE | {"rack_addendum_mm": 13.0}),
    # the tip plane above what the involute can generate
    ("gear_addendum_mm", 11.5, 12.0, 11.533, {"rack_addendum_mm": 13.0, "gear_outer_radius_mm": 481.0}),
    ("shaper_tip_radius_mm", 1.311, 1.312, 1.3112, {}),
    # a rounding so large that its centre lies below the base circle
    ("shaper_tip_radius_mm", 1.311, 100.0, 1.3112, {}),
    ("shaper_addendum_mm", 8.9, 9.1, 8.9976, {"shaper_tip_radius_mm": 0.0}),
    # the pinion's tip in the gear's fillet
    ("shaper_tip_radius_mm", 0.9, 1.2, 0.9627, {"pinion_addendum_mm": 7.5}),
    ("pinion_addendum_mm", 7.9, 8.1, 7.9375, {"shaper_tip_radius_mm": 0.0}),
    ("pinion_addendum_mm", 8.8, 8.9, 8.8777, {"shaper_addendum_mm": 8.95, "shaper_tip_radius_mm": 0.0}),
    # the gear's tip in the pinion's fillet: the rack's straight flank must be as deep as the gear's addendum
    ("rack_tip_radius_mm", 1.7, 1.9, 1.7969, {"gear_addendum_mm": 6.9, "gear_outer_radius_mm": 550.0}),
    ("rack_addendum_mm", 7.0, 6.5, 6.9, {"gear_addendum_mm": 6.9, "rack_tip_radius_mm": 0.0} | SHORT_FACE),
    # undercut by the rack
    ("rack_tip_radius_mm", 1.3, 1.2, 1.21636, UNDERCUT_PINION | {"rack_addendum_mm": 6.0}),
    ("rack_addendum_mm", 5.5, 9.0, 5.52865, UNDERCUT_PINION | {"rack_tip_radius_mm": 0.5}),
    # the roundings of the edges meet
    ("gear_tip_edge_radius_mm", 0.7, 0.72, 0.7138, {}),
    ("pinion_tip_edge_radius_mm", 3.1, 3.2, 3.1144, {}),
]


@pytest.mark.parametrize(("field", "sound", "wrong", "limit", "others"), FLIPS)
def test_a_limit_flips_the_verdict(
    field: str, sound: float, wrong: float, limit: float, others: dict[str, float]
) -> None:
    assert field not in problems(scene_with(**others | {field: sound}))
    problem = problems(scene_with(**others | {field: wrong}))[field]
    assert problem.value == wrong
    stated = min(limits(problem), key=lambda number: abs(number - limit))
    assert stated == pytest.approx(limit, rel=1e-4)
    # the number in the message is the limit, to its last digit; close to it another field may serve as well
    step = 1.1e-5 * limit * (1.0 if sound > wrong else -1.0)
    assert field not in problems(scene_with(**others | {field: stated + step}))
    assert problems(scene_with(**others | {field: stated - step}))


@pytest.mark.parametrize("field", ["gear_inner_radius_mm", "shaper_tip_radius_mm", "pinion_tip_edge_radius_mm"])
def test_a_limit_that_belongs_to_the_range_can_be_typed_in(field: str) -> None:
    _, _, wrong, limit, others = next(flip for flip in FLIPS if flip[0] == field)
    stated = min(
        limits(problems(scene_with(**others | {field: wrong}))[field]), key=lambda number: abs(number - limit)
    )
    assert field not in problems(scene_with(**others | {field: stated}))


def test_the_message_names_the_largest_shaper_tip_radius() -> None:
    problem = problems(scene_with(shaper_tip_radius_mm=1.4))["shaper_tip_radius_mm"]
    assert "fully round at 1.311" in problem.fix
    assert problem.allowed.startswith("0 to 1.311")


def test_a_pinion_form_point_that_just_serves() -> None:
    """Design, section 3: 0.38 m serves l up to 15.49 mm, where 15.03 mm is needed; 0.45 m does not."""
    assert problems(scene_with(rack_tip_radius_mm=0.38 * MODULE)) == {}
    # by itself 0.433 m would serve, but the rack's crest is fully round before
    problem = problems(scene_with(rack_tip_radius_mm=0.45 * MODULE))["rack_tip_radius_mm"]
    assert limits(problem) == [0.0, 2.01855]
    mesh = FaceGearMesh(scene_with(rack_tip_radius_mm=0.38 * MODULE).gear_pair, Placement())
    to_base = mesh.pinion.pitch_radius * sin(radians(25.0))
    pinion = mesh.pinion
    reach = to_base - pinion.base_radius * pinion.form_roll_angle
    assert reach == pytest.approx(15.49, abs=0.005)
    assert mesh.gear.gear_addendum / sin(radians(25.0)) == pytest.approx(15.03, abs=0.005)


def test_a_low_pressure_angle_leaves_nothing_inside_the_pitch_radius() -> None:
    scene = scene_with(pressure_angle_deg=12.0, gear_teeth=30, gear_inner_radius_mm=94.0, gear_outer_radius_mm=97.0)
    problem = problems(scene)["gear_inner_radius_mm"]
    assert limits(problem)[0] > scene.gear_pair.gear_pitch_radius_mm
    assert "pressure angle" in problem.fix


def test_several_problems_at_once() -> None:
    found = problems(
        scene_with(
            gear_inner_radius_mm=460.0,
            gear_outer_radius_mm=580.0,
            shaper_tip_radius_mm=1.5,
            rack_tip_radius_mm=0.45 * MODULE,
            pinion_addendum_mm=9.0,
        )
    )
    assert found.keys() == {
        "gear_inner_radius_mm",
        "gear_outer_radius_mm",
        "shaper_tip_radius_mm",
        "rack_tip_radius_mm",
        "pinion_addendum_mm",
    }


# ---- the control point


@pytest.mark.parametrize(
    ("radius", "lowest", "highest"),
    [
        # pinion tip edge at l = -12.89 mm, gear tip edge
        (508.0, -5.449, 6.160),
        # the deepest that the pinion's involute reaches, not the gear's tip
        (480.0, -2.655, 5.462),
        (560.0, -6.215, 6.183),
    ],
)
def test_the_control_point_lies_on_the_active_flank(radius: float, lowest: float, highest: float) -> None:
    for height in (lowest + 0.01, 0.0, highest - 0.01):
        assert problems(scene_with_point(radius, height)) == {}
    for height in (lowest - 0.01, highest + 0.01, -7.5, 6.3):
        found = problems(scene_with_point(radius, height))
        assert found.keys() == {"wear.control_point.height_mm"}
        assert limits(found["wear.control_point.height_mm"])[:2] == pytest.approx([lowest, highest], abs=2e-3)


def test_the_reach_is_that_of_the_path_of_contact_in_the_pitch_plane() -> None:
    """At radius 508 the contact stays within 0.1 mm of the plane z = L0: ends of the path at sharp tips."""
    scene = scene_with_point(508.0, 7.0, gear_tip_edge_radius_mm=0.0, pinion_tip_edge_radius_mm=0.0)
    low, high = limits(problems(scene)["wear.control_point.height_mm"])[:2]
    assert low == pytest.approx(-13.07 * sin(radians(25.0)), abs=5e-3)
    assert high == pytest.approx(6.35, abs=1e-5)


def test_a_control_point_where_the_pinion_meets_no_flank() -> None:
    scene = scene_with_point(465.3, 6.0, gear_inner_radius_mm=465.2)
    assert problems(scene).keys() <= {"wear.control_point.radius_mm", "wear.control_point.height_mm"}
    assert problems(scene)


def test_a_control_point_on_an_unsound_tooth_is_not_judged() -> None:
    assert problems(scene_with_point(508.0, 7.0, shaper_tip_radius_mm=1.4)).keys() == {"shaper_tip_radius_mm"}


# ---- never an exception


@st.composite
def strange_scenes(draw: st.DrawFn) -> Scene:
    """Scenes whose fields each keep their own range, however they go together."""
    teeth = st.integers(12, 1000)
    module = draw(st.one_of(st.floats(0.1, 20.0), st.floats(5e-324, 1e308)))
    lengths = st.one_of(st.floats(0.0, 3.0), st.floats(0.0, 100.0), st.just(1e-300)).map(lambda x: x * module)
    gear_teeth = draw(teeth)
    radius = 0.5 * module * gear_teeth
    names = [
        f"{body}_{what}_mm"
        for body in ("pinion", "gear")
        for what in ("addendum", "tip_edge_radius", "end_edge_radius")
    ]
    names += [f"{cutter}_{what}_mm" for cutter in ("shaper", "rack") for what in ("addendum", "tip_radius")]
    return scene_with_point(
        radius * draw(st.floats(0.5, 1.5)),
        draw(st.floats(-3.0, 3.0)) * module,
        pinion_teeth=draw(teeth),
        shaper_teeth=draw(teeth),
        gear_teeth=gear_teeth,
        module_mm=module,
        pressure_angle_deg=draw(st.floats(10.0, 35.0)),
        gear_inner_radius_mm=radius * draw(st.floats(0.01, 1.0)),
        gear_outer_radius_mm=radius * draw(st.floats(1.0, 10.0)),
        **{name: draw(lengths) for name in names},
    )


@given(strange_scenes())
def test_nothing_raises(scene: Scene) -> None:
    for problem in geometric_problems(scene):
        assert problem.field.startswith(("gear_pair.", "wear.control_point."))
        assert problem.allowed and problem.fix
        str(problem)


@given(
    pinion_teeth=st.integers(20, 60),
    extra_teeth=st.integers(1, 3),
    gear_teeth=st.integers(80, 300),
    pressure_angle=st.floats(18.0, 28.0),
    inner=st.floats(0.90, 0.999),
    outer=st.floats(1.001, 1.12),
    tip_radius=st.floats(0.0, 0.3),
)
def test_a_sound_scene_has_sound_sections(
    pinion_teeth: int,
    extra_teeth: int,
    gear_teeth: int,
    pressure_angle: float,
    inner: float,
    outer: float,
    tip_radius: float,
) -> None:
    """Where nothing is reported, every outline descends from tip to root within its half of the pitch."""
    radius = 0.5 * MODULE * gear_teeth
    scene = scene_with(
        pinion_teeth=pinion_teeth,
        shaper_teeth=pinion_teeth + extra_teeth,
        gear_teeth=gear_teeth,
        pressure_angle_deg=pressure_angle,
        gear_inner_radius_mm=radius * inner,
        gear_outer_radius_mm=radius * outer,
        shaper_tip_radius_mm=tip_radius * MODULE,
    )
    if geometric_problems(scene):
        return
    mesh = FaceGearMesh(scene.gear_pair, Placement())
    for face in (radius * inner, radius, radius * outer):
        section = mesh.gear.section(face)
        for outline in (section.flank, section.fillet):
            across, up = outline.T
            assert (across[1:] - across[:-1]).min() > -1e-9
            assert (up[1:] - up[:-1]).max() < 1e-9
        assert section.flank[0, 0] > 0.0
        assert section.fillet[-1, 0] <= pi * face / gear_teeth + 1e-9

"""Scenes of cylindrical pairs: fields, defaults, limits of the teeth, files in and out, changes."""

from math import pi

import pytest

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.scene import CylindricalPair, FaceGearPair, parse_scene, scene_from_dict
from tests.scenes import TINY, problems_of

NAME = "spur_fzg_c"
REQUIRED_ONLY = """
[gear_pair]
type = "cylindrical"
pinion_teeth = 20
gear_teeth = 50
normal_module_mm = 2
pressure_angle_deg = 20
pinion_face_width_mm = 20

[operation]
pinion_torque_Nm = 100
"""


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    return sw.load_scene(NAME)


def test_shipped_scene_is_there_and_sound(scene):
    assert NAME in sw.shipped_scenes()
    assert isinstance(scene.gear_pair, CylindricalPair)
    assert geometric_problems(scene) == []
    assert scene.wear is not None and scene.wear.worn_bodies == ("pinion", "gear")


def test_the_face_gear_scene_is_what_it_was():
    scene = sw.load_scene("face_gear_25x160")
    assert isinstance(scene.gear_pair, FaceGearPair)
    assert scene.sha256 == "00361f5862a480e6f18978dfe57696ec9f8d28a8725c162565c4df0cae1db1a3"


def test_defaults_follow_iso_21771():
    pair = parse_scene(REQUIRED_ONLY).gear_pair
    assert isinstance(pair, CylindricalPair)
    assert pair.centre_distance_mm == pytest.approx(70.0)
    assert (pair.pinion_tip_diameter_mm, pair.gear_tip_diameter_mm) == pytest.approx((44.0, 104.0))
    assert (pair.pinion_rack_addendum_mm, pair.pinion_rack_tip_radius_mm) == (2.5, 0.76)
    assert pair.gear_face_width_mm == 20.0
    assert pair.helix_angle_deg == 0.0
    inside = parse_scene(REQUIRED_ONLY.replace("gear_teeth = 50", "gear_teeth = -80")).gear_pair
    assert isinstance(inside, CylindricalPair)
    assert inside.internal
    assert inside.centre_distance_mm == pytest.approx(60.0)
    assert 156.0 <= inside.gear_tip_diameter_mm < 160.0  # never deeper than one module


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"gear_pair.helix_angle_deg": 12.5, "gear_pair.hand": "left", "gear_pair.centre_distance_mm": None},
        {"wear.control_point.face_mm": 1.0, "wear.control_point.height_mm": -1.0},
        {"effects.friction": {}},
    ],
    ids=str,
)
def test_toml_round_trip(scene, changes):
    changed = scene.replace(changes)
    again = parse_scene(changed.to_toml(), check=geometric_problems)
    assert again == changed
    assert again.to_toml() == changed.to_toml()
    assert again.sha256 == changed.sha256


def test_defaults_are_derived_anew(scene):
    wider = scene.replace({"gear_pair.pinion_face_width_mm": 20.0})
    assert wider.gear_pair.gear_face_width_mm == 20.0
    free = scene.replace({"gear_pair.centre_distance_mm": None, "gear_pair.gear_teeth": 25})
    assert free.gear_pair.centre_distance_mm == pytest.approx(91.5 + 2.25, abs=0.02)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("gear_pair.type", "bevel"),
        ("gear_pair.pinion_teeth", 11),
        ("gear_pair.gear_teeth", 0),
        ("gear_pair.gear_teeth", -11),
        ("gear_pair.gear_teeth", 301),
        ("gear_pair.helix_angle_deg", -10.0),
        ("gear_pair.helix_angle_deg", 46.0),
        ("gear_pair.hand", "rigth"),
        ("gear_pair.pinion_profile_shift", 2.1),
        ("gear_pair.centre_distance_mm", -91.5),
        ("gear_pair.gear_rim_thickness_mm", 0.0),
    ],
)
def test_each_field_has_a_range(scene, key, value):
    problem = problems_of(scene.replace, {key: value})[key]
    assert problem.allowed
    assert problem.fix


def test_names_are_those_of_the_kind(scene):
    misspelled = {"gear_pair.modul_mm": 4.5, "gear_pair.shaper_teeth": 28, "gear_pair.helix_angle": 3}
    problems = problems_of(scene.replace, misspelled)
    assert "normal_module_mm" in problems["gear_pair.modul_mm"].fix
    assert "helix_angle_deg" in problems["gear_pair.helix_angle"].fix
    face_gear = sw.load_scene("face_gear_25x160")
    assert (
        "cylindrical"
        in problems_of(face_gear.replace, {"gear_pair.centre_distance_mm": 90.0})["gear_pair.centre_distance_mm"].fix
    )


def test_a_misspelled_type_is_read_as_the_one_that_was_meant():
    text = REQUIRED_ONLY.replace('"cylindrical"', '"cilindrical"').replace("= 100", "= -1")
    found = problems_of(parse_scene, text)
    assert set(found) == {"gear_pair.type", "operation.pinion_torque_Nm"}
    assert "cylindrical" in found["gear_pair.type"].fix


def test_without_a_type_the_names_decide_what_is_missing():
    text = REQUIRED_ONLY.replace('type = "cylindrical"\n', "")
    assert list(problems_of(parse_scene, text)) == ["gear_pair.type"]


LIMITS = [
    ({"pinion_teeth": 12, "pinion_profile_shift": 0.0}, "pinion_profile_shift", "undercut"),
    ({"pinion_profile_shift": 0.5, "centre_distance_mm": 91.5}, "centre_distance_mm", "jam"),
    ({"pinion_teeth": 16, "pinion_profile_shift": -2.0}, "pinion_profile_shift", "raise their sum"),
    ({"pinion_teeth": 16, "gear_profile_shift": -2.0}, "gear_profile_shift", "raise their sum"),
    ({"centre_distance_mm": 80.0}, "centre_distance_mm", "line of action"),
    ({"pinion_tip_diameter_mm": 95.0}, "pinion_tip_diameter_mm", "pointed"),
    ({"pinion_tip_diameter_mm": 84.9}, "pinion_tip_diameter_mm", "clearance"),
    ({"pinion_rack_tip_radius_mm": 2.4, "pinion_rack_addendum_mm": 4.6}, "gear_tip_diameter_mm", "fillet"),
    ({"pinion_tip_diameter_mm": 77.0, "gear_tip_diameter_mm": 113.0}, "pinion_tip_diameter_mm", "contact ratio"),
    ({"helix_angle_deg": 40.0, "pinion_face_width_mm": 200.0}, "helix_angle_deg", "contact ratio"),
    ({"gear_teeth": -15}, "gear_teeth", "more teeth"),
    (
        {"pinion_teeth": 20, "gear_teeth": -24, "pinion_profile_shift": 0.6, "gear_profile_shift": -0.6},
        "pinion_tip_diameter_mm",
        "foul",
    ),
    ({"pinion_bore_radius_mm": 36.0}, "pinion_bore_radius_mm", "radius"),
    ({"gear_rim_thickness_mm": 60.0}, "gear_rim_thickness_mm", "bore"),
    ({"pinion_tip_edge_radius_mm": 3.0}, "pinion_tip_edge_radius_mm", "top land"),
    ({"pinion_end_edge_radius_mm": 7.0}, "pinion_end_edge_radius_mm", "0.2"),
    ({"face_offset_mm": 8.0}, "face_offset_mm", "middle"),
    ({"gear_rack_tip_radius_mm": 2.5}, "gear_rack_tip_radius_mm", "round"),
]


@pytest.mark.parametrize(("changes", "field", "word"), LIMITS, ids=[f"{field}-{word}" for _, field, word in LIMITS])
def test_limits_of_the_teeth(scene, changes, field, word):
    changed = {f"gear_pair.{name}": value for name, value in changes.items()}
    if {"pinion_teeth", "gear_teeth", "helix_angle_deg"} & changes.keys():
        changed["gear_pair.centre_distance_mm"] = None
    problem = problems_of(scene.replace, changed)[f"gear_pair.{field}"]
    assert word in problem.fix + problem.allowed


def test_limits_in_messages_are_accepted(scene):
    """The shift that the message on undercut asks for makes the pinion sound."""
    pair = {"pinion_teeth": 12, "pinion_profile_shift": 0.0, "centre_distance_mm": None}
    changes = {f"gear_pair.{name}": value for name, value in pair.items()}
    allowed = problems_of(scene.replace, changes)["gear_pair.pinion_profile_shift"].allowed
    least = float(allowed.removeprefix("at least "))
    sound = scene.replace({**changes, "gear_pair.pinion_profile_shift": least})
    assert sound.gear_pair.pinion_teeth == 12


def test_everything_wrong_is_said_at_once(scene):
    found = problems_of(
        scene.replace,
        {
            "gear_pair.pinion_bore_radius_mm": 40.0,
            "gear_pair.pinion_tip_diameter_mm": 95.0,
            "operation.pinion_torque_Nm": 0,
            "numerics.harmnics": 3,
        },
    )
    assert {"operation.pinion_torque_Nm", "numerics.harmnics"} <= set(found)


@pytest.mark.parametrize(
    ("point", "key"),
    [({"face_mm": 8.0, "height_mm": 0.0}, "face_mm"), ({"face_mm": 0.0, "height_mm": -5.0}, "height_mm")],
)
def test_control_point_lies_on_the_active_flank(scene, point, key):
    assert list(problems_of(scene.replace, {"wear.control_point": point})) == [f"wear.control_point.{key}"]


def test_control_depths_need_a_control_point(scene):
    found = problems_of(scene.replace, {"wear.until.control_depths_um": [1.0]})
    assert "face_mm" in found["wear.control_point"].allowed


def test_a_scene_can_change_its_kind(scene):
    table = {
        "type": "face_gear", "pinion_teeth": 25, "shaper_teeth": 28, "gear_teeth": 160, "module_mm": 6.35,
        "pressure_angle_deg": 25, "gear_inner_radius_mm": 480, "gear_outer_radius_mm": 560,
        "pinion_face_width_mm": 80,
    }  # fmt: skip
    changed = scene_from_dict(scene.to_dict() | {"gear_pair": table}, check=geometric_problems)
    assert isinstance(changed.gear_pair, FaceGearPair)


def test_plan_says_what_it_is(scene):
    assert "spur gears 16/24" in str(sw.plan(scene))
    helical = scene.replace({"gear_pair.helix_angle_deg": 10.0, "gear_pair.centre_distance_mm": None})
    assert "helical gears 16/24" in str(sw.plan(helical))
    assert any("ISO 21771" in source for source in sw.plan(scene).references)


@pytest.mark.slow
def test_every_answer_works_for_it(scene, tmp_path):
    """Wear, results in and out, tooth contact analysis and the report, on a coarse grid."""
    small = scene.replace(TINY | {"numerics.wear_steps": 1})
    tree = sw.simulate(small)
    assert float(tree["flank"].wear_depth.min()) >= 0.0
    assert float(tree["history"].wear_depth_max_pinion[-1]) > 0.0
    sw.save(tree, tmp_path / "worn.nc")
    again = sw.open_results(tmp_path / "worn.nc")
    assert again.attrs["scene_toml"] == small.to_toml()
    sw.report(tree, tmp_path / "worn.html")
    assert (tmp_path / "worn.html").stat().st_size > 10_000
    analysis = sw.tooth_contact_analysis(small)
    assert float(analysis.contact_ratio) == pytest.approx(1.4377, abs=1e-4)
    assert "undercut_radius" not in analysis
    assert float(abs(analysis.transmission_error).max()) < 1e-4
    assert float(analysis.roll_position[-1] - analysis.roll_position[0]) < pi

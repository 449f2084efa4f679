"""Every limit of a pair's teeth with what the pair has: `check_geometry` and `semiwear check`."""

import json
from math import acos, cos, pi, radians, sin, sqrt, tan

import pytest

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.cli import main
from semiwear.scene import load_scene


def told(scene):
    return {one.limit: one for one in sw.check_geometry(scene).margins}


@pytest.fixture(scope="module")
def face_gear():
    return load_scene("face_gear_25x160")


@pytest.fixture(scope="module")
def spur():
    return load_scene("spur_fzg_c")


def test_a_face_gear_has_the_published_limits(face_gear):
    rows = told(face_gear)
    assert rows["inner radius of the gear (undercut)"].low == pytest.approx(465.17, abs=0.005)
    assert rows["outer radius of the gear (pointing)"].high == pytest.approx(569.33, abs=0.01)
    assert rows["tip thickness of the gear, outer radius"].value == pytest.approx(2 * 0.374, abs=0.002)
    assert rows["contact ratio"].value == pytest.approx(1.554, abs=0.001)
    # a rack tip radius of 0.38 m serves l up to 15.49 mm: the gear's addendum is then at most 15.49 sin(alpha)
    tight = told(face_gear.replace({"gear_pair.rack_tip_radius_mm": 0.31 * 6.35}))
    limit = tight["addendum of the gear (interference)"].high
    assert limit == pytest.approx(1.25 * 6.35 - (1.0 - sin(radians(25))) * 0.31 * 6.35)


def test_a_face_gear_that_runs_is_not_said_to_be_refused(face_gear):
    """Below a contact ratio of 1 the teeth hand over on their edges: told, and no limit."""
    low = face_gear.replace({"gear_pair.gear_addendum_mm": 0.635})
    row = told(low)["contact ratio"]
    assert row.value < 1.0 and row.holds and "on their edges" in row.usual
    assert sw.check_geometry(low).holds


@pytest.mark.parametrize("teeth", [24, -60])
def test_the_row_of_jamming_is_broken_exactly_where_the_scene_is_refused(spur, teeth):
    changes = {"pinion_profile_shift": 0.0, "gear_profile_shift": 0.0, "gear_teeth": teeth}
    changes |= dict.fromkeys(("centre_distance_mm", "pinion_tip_diameter_mm", "gear_tip_diameter_mm"))
    pair = spur.replace({f"gear_pair.{name}": value for name, value in changes.items()})
    row, tight = told(pair)["centre distance (jamming)"], pair.gear_pair.centre_distance_mm
    limit, side = (row.high, -1.0) if teeth < 0 else (row.low, 1.0)
    assert 0.0 < side * (tight - limit) < 1e-3 * 4.5
    for inside in (1e-6, -1e-6):
        moved = pair.replace({"gear_pair.centre_distance_mm": limit + side * inside})
        refused = any(one.field == "gear_pair.centre_distance_mm" for one in geometric_problems(moved))
        assert refused == (inside < 0.0)
        assert told(moved)["centre distance (jamming)"].holds != refused


@pytest.mark.parametrize("teeth", [24, -60])
def test_a_misalignment_that_uses_up_the_backlash_is_remarked(spur, teeth):
    changes = {"pinion_profile_shift": 0.0, "gear_profile_shift": 0.0, "gear_teeth": teeth}
    changes |= dict.fromkeys(("centre_distance_mm", "pinion_tip_diameter_mm", "gear_tip_diameter_mm"))
    pair = spur.replace({f"gear_pair.{name}": value for name, value in changes.items()})
    closer = 1.0 if teeth < 0 else -1.0
    for shift in (0.5 * closer, -0.5 * closer):
        moved = pair.replace({"effects.misalignment.axial_gear_mm": shift})
        row = told(moved)["centre distance (jamming)"]
        distance = pair.gear_pair.centre_distance_mm + shift
        assert row.holds and (f"{distance:.6g} mm" in row.usual) == (shift == 0.5 * closer)
    assert not told(pair)["centre distance (jamming)"].usual


def test_a_spur_pair_has_the_limits_of_the_closed_forms(spur):
    rows = told(spur)
    pair = spur.gear_pair
    z1, z2, m, alpha = 16, 24, 4.5, radians(20)
    a, x1 = 91.5, pair.pinion_profile_shift
    base = [0.5 * m * z * cos(alpha) for z in (z1, z2)]
    working = acos(sum(base) / a)
    tips = [0.5 * pair.pinion_tip_diameter_mm, 0.5 * pair.gear_tip_diameter_mm]
    length = sum(sqrt(tip**2 - b**2) for tip, b in zip(tips, base, strict=True)) - a * sin(working)
    assert rows["transverse contact ratio"].value == pytest.approx(length / (pi * m * cos(alpha)), rel=1e-12)
    # the tool's straight flank reaches 1.25 - 0.38 (1 - sin alpha) modules deep (ISO 21771)
    depth = 1.25 - 0.38 * (1.0 - sin(alpha))
    assert rows["profile shift of the pinion (undercut)"].low == pytest.approx(depth - 0.5 * z1 * sin(alpha) ** 2)
    # tip thickness s_a = d_a (s/d + inv alpha - inv alpha_a)
    tip_angle = acos(base[0] / tips[0])
    half = (0.5 * pi + 2.0 * x1 * tan(alpha)) / z1 + tan(alpha) - alpha - tan(tip_angle) + tip_angle
    assert rows["tip thickness of the pinion"].value == pytest.approx(2.0 * tips[0] * half)
    root = 0.5 * m * z2 - (1.25 - pair.gear_profile_shift) * m
    assert rows["tip clearance of the pinion"].value == pytest.approx(a - root - tips[0])


RING = {"gear_teeth": -60, "pinion_teeth": 20} | dict.fromkeys(("pinion_profile_shift", "gear_profile_shift"), 0.0)
RING |= {"centre_distance_mm": None}
BROKEN = {
    "undercut": ("spur_fzg_c", {"pinion_profile_shift": -0.3, "centre_distance_mm": None}),
    "pointed": ("spur_fzg_c", {"pinion_tip_diameter_mm": 87.0}),
    "clearance": ("spur_fzg_c", {"gear_rack_addendum_mm": 4.3}),
    "jammed": ("spur_fzg_c", {"centre_distance_mm": 91.0}),
    "parts": ("spur_fzg_c", {"pinion_tip_diameter_mm": 77.0, "gear_tip_diameter_mm": 112.0}),
    "fouls": ("spur_fzg_c", RING | {"gear_teeth": -26}),
    "inner radius": ("face_gear_25x160", {"gear_inner_radius_mm": 450.0}),
    "outer radius": ("face_gear_25x160", {"gear_outer_radius_mm": 580.0}),
    "gear addendum": ("face_gear_25x160", {"gear_addendum_mm": 7.0}),
    "shaper tip": ("face_gear_25x160", {"shaper_tip_radius_mm": 1.4}),
}
SOUND = {
    "spur": ("spur_fzg_c", {}),
    "helical": ("spur_fzg_c", {"helix_angle_deg": 20.0, "centre_distance_mm": None}),
    "internal": ("spur_fzg_c", RING),
    "face gear": ("face_gear_25x160", {}),
}


def changed(name, changes):
    return load_scene(name).replace({f"gear_pair.{field}": value for field, value in changes.items()})


@pytest.mark.parametrize("case", BROKEN)
def test_what_a_scene_is_refused_for_is_a_broken_limit(case):
    scene = changed(*BROKEN[case])
    checked = sw.check_geometry(scene)
    assert not checked.holds and checked.problems == tuple(geometric_problems(scene))
    broken = [one for one in checked.margins if not one.holds]
    fields = {one.field for one in broken}
    assert {problem.field for problem in checked.problems} & fields or case == "clearance", (fields, checked.problems)
    assert broken and "NO" in str(checked)


@pytest.mark.parametrize("case", ["spur", "internal"])
def test_teeth_jam_where_the_scene_is_refused(case):
    """Between a thousandth of a module and that times the cosine of the working angle the margin was kept alone."""
    scene = changed(*SOUND[case])
    pair = scene.gear_pair
    tight = told(scene.replace({"gear_pair.centre_distance_mm": None}))["centre distance (jamming)"]
    limit = tight.high if pair.internal else tight.low
    inwards = 1.0 if pair.internal else -1.0
    for share, holds in ((-0.02, True), (0.02, False)):
        distance = limit + inwards * share * 1e-3 * pair.normal_module_mm
        checked = sw.check_geometry(scene.replace({"gear_pair.centre_distance_mm": distance}))
        (row,) = [one for one in checked.margins if one.limit == "centre distance (jamming)"]
        jam = [one for one in checked.problems if "jam" in one.fix]
        assert row.holds == holds and bool(jam) != holds, (distance, row, checked.problems)


@pytest.mark.parametrize("case", SOUND)
def test_sound_teeth_keep_every_limit(case):
    checked = sw.check_geometry(changed(*SOUND[case]))
    assert checked.holds and not [one for one in checked.margins if not one.holds]
    assert checked.to_dict()["holds"] and "All limits are kept" in str(checked)


def test_a_legal_value_that_is_told_is_accepted():
    scene = changed("face_gear_25x160", {"gear_inner_radius_mm": 450.0, "gear_outer_radius_mm": 580.0})
    rows = told(scene)
    inner = rows["inner radius of the gear (undercut)"].legal.split(" to ")[0]
    outer = rows["outer radius of the gear (pointing)"].legal.split(" to ")[1]
    mended = scene.replace(
        {"gear_pair.gear_inner_radius_mm": float(inner), "gear_pair.gear_outer_radius_mm": float(outer)}
    )
    (problem,) = geometric_problems(mended)  # no land is left for the edges' roundings
    edge = told(mended)["tip edge radius of the gear"]
    assert problem.field == edge.field and not edge.holds
    mended = mended.replace({"gear_pair.gear_tip_edge_radius_mm": float(edge.legal.removeprefix("up to "))})
    assert not geometric_problems(mended)


def test_the_command_tells_limits_of_scenes_that_would_be_refused(capsys):
    assert main(["check", "spur_fzg_c"]) == 0
    assert "All limits are kept." in capsys.readouterr().out
    assert main(["check", "face_gear_25x160", "--set", "gear_pair.gear_inner_radius_mm=450", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    rows = {row["limit"]: row for row in found["limits"]}
    assert not found["holds"] and not rows["inner radius of the gear (undercut)"]["holds"]
    assert rows["outer radius of the gear (pointing)"]["holds"]
    assert "give more" in found["problems"][0]["fix"]
    assert main(["check", "nothing.toml"]) == 2

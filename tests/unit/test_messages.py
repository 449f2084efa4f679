"""What users are told: hints lead to the field that is meant, and defaults are not taken for typed values."""

import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.scene import parse_scene
from semiwear.targets import file_target
from tests.scenes import TINY, problems_of


def told_of(scene: sw.Scene, changes: dict[str, object]) -> list[str]:
    return [str(problem) for problem in problems_of(scene.replace, changes).values()]


# ---------------------------------------------------------------- names


def test_a_torque_is_the_pinions(shipped):
    (told,) = told_of(shipped, {"operation.torque": 500.0})
    assert "did you mean pinion_torque_Nm?" in told


def test_a_face_width_is_that_of_the_pinion_which_every_scene_needs(spur):
    text = spur.to_toml().replace("pinion_face_width_mm", "face_width_mm")
    with pytest.raises(sw.SceneError) as caught:
        parse_scene(text)
    told = str(caught.value)
    assert "did you mean pinion_face_width_mm?" in told
    assert "gear_face_width_mm?" not in told


def test_a_value_with_its_unit_is_told_to_lose_it(shipped):
    for given, wanted in (("500Nm", "500"), ("500 Nm", "500"), ("0,5", "0.5"), ("1e3", "1e3")):
        (told,) = told_of(shipped, {"operation.pinion_torque_Nm": given})
        assert f"give {wanted}" in told or f": {wanted}," in told
    (told,) = told_of(shipped, {"operation.pinion_torque_Nm": "500Nm"})
    assert "quotes" not in told and "Nm" in told.partition("->")[2]


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ({"gear_pair.beta": 10.0}, "did you mean helix_angle_deg?"),
        ({"gear_pair.ratio": 2.0}, "did you mean gear_teeth?"),
        ({"operation.rpm": 100.0}, "did you mean pinion_speed_rpm?"),
        ({"material.pinion.E": 206000.0}, "did you mean youngs_modulus_MPa?"),
        ({"wear.k": 1e-13}, "did you mean coefficient_mm2_per_N?"),
        ({"wear.until.cycles": 10.0}, "did you mean meshes?"),
        ({"gear_pair.d_a1_mm": 50.0}, "did you mean pinion_tip_diameter_mm?"),
        ({"gear_pair.alpha_n": 20.0}, "did you mean pressure_angle_deg?"),
        ({"gear_pair.a_w": 90.0}, "did you mean centre_distance_mm?"),
        ({"gear_pair.pinion_tip_relief_um": 20.0}, "did you mean effects.modification.pinion.tip_relief_um?"),
        ({"effects.modification.pinion.C_a_um": 20.0}, "did you mean tip_relief_um?"),
        ({"effects.tip_relief.pinion_um": 20.0}, "did you mean effects.modification.pinion.tip_relief_um?"),
        ({"wear.wear_coefficient": 1e-13}, "did you mean coefficient_mm2_per_N?"),
        (
            {"material.pinion": "16MnCr5"},
            'any steel, hardened or not, is "steel"; semiwear materials lists them with their sources',
        ),
    ],
)
def test_names_of_textbooks_lead_to_the_field(spur, given, meant):
    told = told_of(spur, given)
    assert told[0].endswith(f"-> {meant}")


def test_a_rating_that_no_scene_has_the_inputs_of_is_refused_with_the_reason(spur):
    (told,) = told_of(spur, {"effects.din_3996": {}})
    assert "worm gears, whose inputs a scene does not have" in told


def test_a_field_of_another_kind_of_pair_is_told_so(spur):
    (told,) = told_of(spur, {"gear_pair.shaft_angle_deg": 90.0})
    assert told.endswith('remove it: it is of gear_pair.type = "face_gear"')
    (told,) = told_of(spur, {"gear_pair.module_mm": 4.0})
    assert told.endswith("did you mean normal_module_mm?")


@pytest.mark.parametrize("kind", ["spur", "helical", "bevel"])
def test_kinds_of_gears_lead_to_the_type_that_holds_them(spur, kind):
    (told,) = told_of(spur, {"gear_pair.type": kind})
    assert 'give "face_gear"' not in told
    assert 'spur and helical gears are "cylindrical", bevel,' in told


@pytest.mark.parametrize(
    ("given", "meant"), [("pinion", '["pinion"]'), ("both", '["pinion", "gear"]'), ("gear", '["gear"]')]
)
def test_a_body_by_itself_is_told_as_a_list(spur, given, meant):
    (told,) = told_of(spur, {"wear.worn_bodies": given})
    assert told.endswith(f"give a list: {meant}")


def test_an_empty_value_is_told_to_be_empty(spur):
    (told,) = told_of(spur, {"operation.pinion_torque_Nm": " "})
    assert told.endswith("it is empty: give a number")


def test_axes_too_far_apart_are_blamed_as_well_as_the_tips(spur):
    (told,) = told_of(spur, {"gear_pair.centre_distance_mm": 95.0})
    assert "lower centre_distance_mm, or raise the tips" in told


def test_options_are_no_fields_of_the_scene(capsys):
    assert main(["plan", "spur_fzg_c", "--set", "nonsense"]) == 2
    assert "semiwear: command line: 1 problem" in capsys.readouterr().err


def test_a_folder_is_no_scene(tmp_path):
    with pytest.raises(sw.SceneError, match="it is a folder: give the file in it"):
        sw.load_scene(tmp_path)


# ---------------------------------------------------------------- effects


def test_set_none_removes_an_effect_or_a_field(capsys):
    added = ["--set", "effects.friction={coefficient = 0.1}"]
    assert main(["plan", "face_gear_25x160", *added]) == 0
    assert "coefficient = 0.1" in " ".join(capsys.readouterr().out.split())
    assert main(["plan", "face_gear_25x160", *added, "--set", "effects.friction=none"]) == 0
    assert "friction: no table" in capsys.readouterr().out
    assert main(["plan", "face_gear_25x160", "--set", "numerics.wear_scheme=None"]) == 0
    capsys.readouterr()
    assert main(["plan", "face_gear_25x160", "--set", "effects.run_life=off"]) == 2
    assert "--set effects.run_life=none" in capsys.readouterr().err


def test_plan_shows_what_effects_are_set_to(shipped):
    told = str(sw.plan(shipped.replace({"effects.shaft_compliance": {}, "effects.friction": {"coefficient": 0.07}})))
    told = " ".join(told.split())
    assert "offset_um_per_kN = 1 (default)" in told
    assert "coefficient = 0.07," in told or "coefficient = 0.07 " in told
    assert "coefficient = 0.07 (default)" not in told


# ---------------------------------------------------------------- angles, lengths


def test_angles_in_radians_are_questioned(spur):
    (told,) = told_of(spur, {"gear_pair.pressure_angle_deg": 0.349})
    assert told.endswith("this looks like radians, give 20")
    helical = spur.replace({"gear_pair.helix_angle_deg": 0.26})
    question = "helix_angle_deg = 0.26, is it in radians (14.9 degrees)?"
    assert f"unusual: {question}" in " ".join(str(sw.plan(helical)).split())
    assert question in [margin.usual for margin in sw.check_geometry(helical).margins]
    helical = spur.replace({"gear_pair.helix_angle_deg": 1.0, "gear_pair.centre_distance_mm": None})
    assert "radians" not in f"{sw.plan(helical)} {sw.check_geometry(helical)}"


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_a_relief_is_no_longer_than_its_flank(shipped, body):
    table = f"effects.modification.{body}"
    lengths = {f"{table}.tip_relief_length_mm": 40.0, f"{table}.root_relief_length_mm": 16.0}
    told = told_of(shipped, lengths)
    longest = {"pinion": "12.903", "gear": "14.91"}[body]  # along the profile, from root to tip
    assert len(told) == 2
    assert all(f"allowed: above 0, up to {longest} mm, the length of the flank's profile" in line for line in told)
    shipped.replace({key: float(longest) for key in lengths})


def test_without_a_kind_of_pair_no_fields_of_one_are_asked_for():
    for text in ("", "[gear_pair]\npinion_teeth = 20\ngear_teeth = 30\n"):
        told = [str(one) for one in problems_of(parse_scene, text).values()]
        assert told[0].startswith("gear_pair.type: missing") and "give the kind first" in told[0]
        assert not any("gear_pair" in line for line in told[1:])
    told = problems_of(parse_scene, "[gear_pair]\nnormal_module_mm = 20\n")
    assert told["gear_pair.type"].fix.endswith('add type = "cylindrical"') and "gear_pair.pinion_teeth" in told


# ---------------------------------------------------------------- the wear coefficient


@pytest.mark.parametrize(("given", "meant"), [(1e-19, "looks like m2/N: give 1e-13"), (1e-3, "Archard's number")])
def test_slips_of_the_wear_coefficients_unit_are_caught(shipped, given, meant):
    for value in (given, {"pinion": 1e-13, "gear": given}):
        (told,) = told_of(shipped, {"wear.coefficient_mm2_per_N": value})
        assert meant in told and "is usual" in told


def test_plan_questions_an_unusual_wear_coefficient(shipped):
    assert "unusual" not in str(sw.plan(shipped))
    assert "unusual: 1e-15" in str(sw.plan(shipped.replace({"wear.coefficient_mm2_per_N": 1e-15})))


# ---------------------------------------------------------------- gear pairs


def test_usual_values_are_named_only_where_they_are_allowed(shipped):
    for told in told_of(shipped, {"gear_pair.module_mm": 2.0, "gear_pair.gear_teeth": 508}):
        if "give less" in told:
            assert "usually" not in told or "do not fit" not in told
    told = told_of(shipped, {"gear_pair.pressure_angle_deg": 20.0})
    (addendum,) = [line for line in told if line.startswith("gear_pair.gear_addendum_mm")]
    assert "below 5.80673 mm" in addendum
    assert "usually 1" not in addendum and "do not fit" in addendum


def test_cutters_of_a_steep_pressure_angle_have_roundings_that_fit(shipped):
    cutters = {"gear_pair.shaper_tip_radius_mm": None, "gear_pair.rack_tip_radius_mm": None}
    for angle in (20.0, 22.0, 25.0):  # as they were
        pair = shipped.gear_pair.__class__(
            **{
                name: getattr(shipped.gear_pair, name)
                for name in (
                    "type",
                    "pinion_teeth",
                    "shaper_teeth",
                    "gear_teeth",
                    "module_mm",
                    "gear_inner_radius_mm",
                )
            },
            gear_outer_radius_mm=560.0,
            pinion_face_width_mm=80.0,
            pressure_angle_deg=angle,
        )
        assert (pair.shaper_tip_radius_mm, pair.rack_tip_radius_mm) == pytest.approx((0.2 * 6.35, 0.3 * 6.35))
    for angle in (26.0, 27.0, 28.0):
        changes = cutters | {"gear_pair.pressure_angle_deg": angle, "gear_pair.gear_tip_edge_radius_mm": 0.1}
        steep = shipped.replace(changes).gear_pair
        for name, share in (("shaper_tip_radius_mm", 0.2), ("rack_tip_radius_mm", 0.3)):
            radius = getattr(steep, name)
            assert 0.0 < radius <= share * steep.module_mm
            if radius < share * steep.module_mm:  # just as much as there is room for
                with pytest.raises(sw.SceneError, match=name):
                    shipped.replace(changes | {f"gear_pair.{name}": 1.002 * radius})


def test_a_default_that_does_not_fit_is_called_one(shipped):
    text = shipped.to_toml()
    text = "\n".join(line for line in text.splitlines() if "pinion_addendum_mm" not in line)
    shallow = {"gear_pair.shaper_addendum_mm": 6.0}
    for scene, words in ((parse_scene(text), "left out, its default here is 6.35"), (shipped, "found 6.35")):
        (addendum,) = [line for line in told_of(scene, shallow) if line.startswith("gear_pair.pinion_addendum_mm")]
        assert words in addendum


def test_a_path_beside_the_pitch_point_is_not_called_a_contact_ratio(spur):
    shifts = {"gear_pair.pinion_profile_shift": -1.9, "gear_pair.gear_profile_shift": -1.9}
    shifts |= {"gear_pair.pinion_teeth": 150, "gear_pair.gear_teeth": 40, "gear_pair.centre_distance_mm": None}
    cleared = {
        f"gear_pair.{body}_{name}_mm": None
        for body in ("pinion", "gear")
        for name in ("tip_diameter", "rack_addendum", "rack_tip_radius")
    }
    removed = {"gear_pair.pinion_bore_radius_mm": None, "gear_pair.gear_rim_thickness_mm": None}
    told = told_of(spur, shifts | cleared | removed)
    assert not any("contact ratio of at most" in line for line in told)
    assert any("base pitches of the pitch point" in line for line in told)


@pytest.mark.slow
def test_flanks_out_of_reach_blame_a_placement_only_where_there_is_one(shipped, spur):
    with pytest.raises(sw.SceneError, match="placement"):
        sw.tooth_contact_analysis(shipped, sw.Placement(axial_gear_mm=20.0))
    soft = {"material.pinion.youngs_modulus_MPa": 500.0, "material.gear.youngs_modulus_MPa": 500.0}
    with pytest.raises(sw.SceneError) as caught:
        sw.loaded_contact(spur.replace(TINY | soft | {"operation.pinion_torque_Nm": 1e6, "wear": None}))
    assert "placement" not in str(caught.value)
    assert "operation.pinion_torque_Nm" in str(caught.value)


def test_an_unknown_ending_of_an_export_is_told_that_the_ending_chooses(tmp_path):
    with pytest.raises(sw.SceneError, match=r"the ending says what is written: e\.g\. .*x\.vtu"):
        file_target("path", tmp_path / "x.rexs", (".vtu", ".stl", ".csv"))

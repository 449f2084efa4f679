"""Scenes as users get them wrong: each error names the field or line, what is allowed there, and a way out."""

import re
from importlib import resources

import pytest

from semiwear.check import geometric_problems
from semiwear.errors import SceneError
from semiwear.scene import parse_scene

TEXT = (resources.files("semiwear.scene") / "scenes" / "face_gear_25x160.toml").read_text(encoding="utf-8")


def to(**values):
    """Other values of fields, as they are typed."""

    def change(text):
        for name, value in values.items():
            text, count = re.subn(rf"(?m)^{name} *=[^#\n]*", lambda _, n=name, v=value: f"{n} = {v} ", text)
            assert count, name
        return text

    return change


def without(start, end=None):
    """Without a field's line, or from one header to the next."""
    pattern = rf"(?ms)^\[{start}\].*?(?=^\[{end}\])" if end else rf"(?m)^{start} *=.*\n"

    def change(text):
        text, count = re.subn(pattern, "", text)
        assert count, start
        return text

    return change


def put(old, new):
    def change(text):
        assert f"\n{old}" in text, old
        return text.replace(f"\n{old}", f"\n{new}", 1)

    return change


def more(lines):
    return lambda text: f"{text}\n{lines}\n"


def only(text):
    return lambda _: text


def both(*changes):
    def change(text):
        for one in changes:
            text = one(text)
        return text

    return change


STEPS = "above 0 and strictly increasing"
EITHER_BODY = '["gear"] or ["pinion"] or ["pinion", "gear"]'
TEETH = "whole number, 12 to 1000"
# what is wrong: the change, the field or line, words of the allowed range, words of the way out
MALFORMED = {
    # no TOML
    "a sentence": (only("this is a gear\n"), "line 1", "TOML syntax", "write name = value"),
    "an open text": (to(title='"Face gear'), "line 6", "TOML syntax", 'close the text with "'),
    "an open header": (put("[wear]", "[wear"), "line 57", "TOML syntax", "[name], in a line of its own"),
    "an open list": (to(control_depths_um="[5, 10"), "line 66", "TOML syntax", "close the list with ]"),
    "a field twice": (put("module_mm", "module_mm = 6\nmodule_mm"), "line 15", "TOML syntax", "twice: remove one"),
    "a table twice": (more("[gear_pair]\nmodule_mm = 1"), "line 74", "TOML syntax", "each table has one header"),
    "a decimal comma": (to(module_mm="6,35"), "line 14", "TOML syntax", "a decimal point, not a comma"),
    "a decimal comma in a table": (only("a = {from = 0, to = 0,5}\n"), "line 1", "TOML syntax", "not a comma"),
    "a unit": (to(module_mm="6.35 mm"), "line 14", "TOML syntax", "leave the unit out, it is in the field's name"),
    "None": (to(pinion_bore_radius_mm="None"), "line 39", "TOML syntax", "leave the line out"),
    "no value": (to(pinion_bore_radius_mm=""), "line 39", "TOML syntax", "leave the line out"),
    "bare text": (to(fidelity="line"), "line 71", "TOML syntax", "write text in quotes"),
    "no end of lists": (only("a = " + "[" * 3000), "file", "plain values", "take the lists apart"),
    "a number without end": (to(pinion_teeth="1" * 5000), "file", "plain values", "shorten it"),
    # types
    "a unit in text": (to(module_mm='"6.35 mm"'), "gear_pair.module_mm", "greater than 0 mm", "without the unit"),
    "a number in text": (to(pinion_teeth='"25"'), "gear_pair.pinion_teeth", TEETH, "without quotes"),
    "half a tooth": (to(pinion_teeth="25.5"), "gear_pair.pinion_teeth", TEETH, "a whole number, e.g. 26"),
    "true": (to(gear_teeth="true"), "gear_pair.gear_teeth", TEETH, "not true or false"),
    "a list": (to(module_mm="[6.35]"), "gear_pair.module_mm", "greater than 0 mm", "one number, not a list"),
    "a table": (to(module_mm="{value = 6.35}"), "gear_pair.module_mm", "greater than 0 mm", "not a table"),
    "a date": (to(module_mm="2024-01-01"), "gear_pair.module_mm", "greater than 0 mm", "one number, not a date"),
    "a number for text": (to(title="5"), "title", "text", "give text in quotes"),
    "text for a list": (to(worn_bodies='"gear"'), "wear.worn_bodies", EITHER_BODY, 'give a list: ["gear"]'),
    "a value for a table": (
        both(without("operation", "wear"), put("[gear_pair]", "operation = 1600\n[gear_pair]")),
        "operation", "a table", "write the header [operation]",
    ),
    # values
    "nan": (to(pinion_torque_Nm="nan"), "operation.pinion_torque_Nm", "greater than 0 N m", "a finite number"),
    "infinity": (to(youngs_modulus_MPa="inf"), "material.gear.youngs_modulus_MPa", "MPa", "a finite number"),
    "beyond floats": (to(pinion_torque_Nm="1e999"), "operation.pinion_torque_Nm", "N m", "a finite number"),
    "negative torque": (to(pinion_torque_Nm="-1600"), "operation.pinion_torque_Nm", "greater than 0", '"coast"'),
    "no module": (to(module_mm="0"), "gear_pair.module_mm", "greater than 0 mm", "pitch diameter divided by"),
    "negative teeth": (to(gear_teeth="-160"), "gear_pair.gear_teeth", TEETH, "count the teeth"),
    "two teeth": (to(pinion_teeth="2"), "gear_pair.pinion_teeth", TEETH, "count the teeth of the whole gear"),
    "few slices": (more("face_slices = 3"), "numerics.face_slices", "7 to 10000", "61 is usual"),
    "slices without end": (more("face_slices = 1000000"), "numerics.face_slices", "7 to 10000", "61 is usual"),
    "no body": (to(worn_bodies="[]"), "wear.worn_bodies", EITHER_BODY, "without wear remove [wear]"),
    "a body twice": (to(worn_bodies='["gear", "gear"]'), "wear.worn_bodies", EITHER_BODY, 'give ["gear"]'),
    "a wheel": (to(worn_bodies='["wheel"]'), "wear.worn_bodies", EITHER_BODY, 'give ["gear"]'),
    "a left flank": (to(loaded_flank='"left"'), "operation.loaded_flank", '"drive" or "coast"', 'give "drive"'),
    "a misspelled choice": (to(wear_scheme='"implict"'), "numerics.wear_scheme", '"explicit"', 'mean "implicit"?'),
    "elements": (to(fidelity='"fem"'), "numerics.fidelity", '"line" or "patch"', 'give "line"'),
    "another gear": (to(type='"facegear"'), "gear_pair.type", '"face_gear"', 'did you mean "face_gear"?'),
    "falling depths": (to(control_depths_um="[10, 5]"), "wear.until.control_depths_um", STEPS, "give [5.0, 10.0]"),
    "no depths": (to(control_depths_um="[]"), "wear.until.control_depths_um", STEPS, "e.g. [5, 10, 15]"),
    "unworn depth": (to(control_depths_um="[0, 5]"), "wear.until.control_depths_um", STEPS, "give [5.0]"),
    # units
    "diameters": (
        to(gear_inner_radius_mm="960", gear_outer_radius_mm="1120"),
        "gear_pair.gear_outer_radius_mm", "above the pitch radius (508 mm)", "like diameters: .*give 480 and 560",
    ),
    "radii in metres": (
        to(gear_inner_radius_mm="0.48", gear_outer_radius_mm="0.56"),
        "gear_pair.gear_outer_radius_mm", "above the pitch radius (508 mm)", "module times gear_teeth / 2",
    ),
    "module in metres": (
        to(module_mm="0.00635"), "gear_pair.gear_inner_radius_mm", "pitch radius (0.508 mm)", "correct the radii",
    ),
    "GPa": (to(youngs_modulus_MPa="207"), "material.gear.youngs_modulus_MPa", "MPa", "looks like GPa: give 207000"),
    "Pa": (to(youngs_modulus_MPa="207e9"), "material.pinion.youngs_modulus_MPa", "MPa", "like Pa: give 207000"),
    "radians": (to(pressure_angle_deg="0.4363"), "gear_pair.pressure_angle_deg", "10 to 35 degrees", "in degrees"),
    "per cent": (to(poissons_ratio="30"), "material.gear.poissons_ratio", "above 0 and below 0.5", "0.3 for steel"),
    "control diameter": (
        to(radius_mm="1016"), "wear.control_point.radius_mm", "480 to 560 mm", "a gear radius, not a diameter",
    ),
    "bore diameter": (
        to(pinion_bore_radius_mm="100"), "gear_pair.pinion_bore_radius_mm", "root radius", "a radius, not a diameter",
    ),
    # names
    "a misspelled field": (
        put("pressure_angle_deg", "presure_angle_deg"),
        "gear_pair.presure_angle_deg", "a name of [gear_pair]", "did you mean pressure_angle_deg? It is missing",
    ),
    "no unit in a name": (put("module_mm", "module"), "gear_pair.module", "a name of", "did you mean module_mm?"),
    "capitals": (put("gear_teeth", "Gear_Teeth"), "gear_pair.Gear_Teeth", "a name of", "did you mean gear_teeth?"),
    "a misspelled table": (put("[operation]", "[opperation]"), "opperation", "top level", "did you mean operation?"),
    "plural": (put("[material.pinion]", "[materials.pinion]"), "materials", "top level", "did you mean material?"),
    "in another table": (
        put("[operation]", '[operation]\nwear_mapping = "interpolated"'),
        "operation.wear_mapping", "a name of [operation]", "did you mean numerics.wear_mapping?",
    ),
    "a misspelled effect": (
        more("[effects.missalignment]"), "effects.missalignment", "a name of [effects]", "did you mean misalignment?",
    ),
    "an unknown effect": (more("[effects.plasticity]"), "effects.plasticity", "lubrication, ", "remove it"),
    "an unknown field": (put("[gear_pair]", "colour = 3\n[gear_pair]"), "colour", "gear_pair", "remove it"),
    "a strange name": (more('"\u2699" = 3'), "numerics.\u2699", "a name of [numerics]", "remove it"),
    # what is missing, too much or in contradiction
    "nothing": (only(""), "gear_pair.type", '"face_gear"', "give the kind first"),
    "no torque": (without("pinion_torque_Nm"), "operation.pinion_torque_Nm", "N m", "needed by [operation]: add it"),
    "no coefficient": (without("coefficient_mm2_per_N"), "wear.coefficient_mm2_per_N", "mm2/N", "needed by [wear]"),
    "no end": (without("control_depths_um"), "wear.until", "one of meshes, hours and control_depths_um", "add the"),
    "two ends": (put("[wear.until]", "[wear.until]\nmeshes = 1e9"), "wear.until", "exactly one of", "remove one"),
    "no control point": (
        without(r"wear.control_point", "numerics"),
        "wear.control_point", "a table with radius_mm and height_mm", "or give meshes instead",
    ),
    "a coefficient of one of two bodies": (
        to(worn_bodies='["pinion", "gear"]', coefficient_mm2_per_N="{gear = 1e-13}"),
        "wear.coefficient_mm2_per_N", "with pinion, as needed by wear.worn_bodies", "add pinion = 1e-13",
    ),
    "the other body's coefficient": (
        to(coefficient_mm2_per_N="{pinion = 1e-13}"),
        "wear.coefficient_mm2_per_N", "with gear, as needed by wear.worn_bodies", "one number for both bodies",
    ),
    "nobody's coefficient": (
        to(coefficient_mm2_per_N="{wheel = 1e-13}"),
        "wear.coefficient_mm2_per_N", "{pinion = ..., gear = ...}", "not wheel",
    ),
    "marched lines": (
        more('wear_mapping = "marched"'), "numerics.wear_mapping", '"line"', 'set numerics.fidelity = "patch"',
    ),
    "swapped radii": (
        to(gear_inner_radius_mm="560", gear_outer_radius_mm="480"),
        "gear_pair.gear_outer_radius_mm", "greater than gear_inner_radius_mm (560 mm)", "swap them: 480 and 560",
    ),
    "shares of more than all": (
        more("[effects.load_spectrum]\ntorques_Nm = [800, 1600]\nshares = [0.5, 0.6]"),
        "effects.load_spectrum.shares", "sum to 1", "they sum to 1.1",
    ),
    "shares of other torques": (
        more("[effects.load_spectrum]\ntorques_Nm = [800, 1600]\nshares = [1.0]"),
        "effects.load_spectrum.shares", "as many as torques_Nm (2)", "one share for each torque",
    ),
    "a film without speed": (
        more("[effects.lubrication]"), "operation.pinion_speed_rpm", "rev/min", "by [effects.lubrication]: add it",
    ),
    "heat without speed": (
        more("[effects.flash_temperature]"), "operation.pinion_speed_rpm", "rev/min", "[effects.flash_temperature]",
    ),
    "an empty container": (
        more("[effects.modification]"), "effects.modification", "one or more of pinion, gear", "or leave it out",
    ),
    # impossible geometry
    "undercut": (
        to(gear_inner_radius_mm="440"), "gear_pair.gear_inner_radius_mm", "465.174 to 508", "undercuts .*give more",
    ),
    "pointed": (
        to(gear_outer_radius_mm="590"), "gear_pair.gear_outer_radius_mm", "508 to 569.325", "pointed .*: give less",
    ),
    "a pointed shaper": (
        to(shaper_addendum_mm="12"), "gear_pair.shaper_addendum_mm", "up to 8.99758 mm", "usually 1.25 m",
    ),
    "a crest rounder than round": (
        to(rack_tip_radius_mm="2.9"), "gear_pair.rack_tip_radius_mm", "0 to 2.01855", "fully round at .*: give less",
    ),
    "a small shaper": (
        to(shaper_teeth="24"), "gear_pair.shaper_teeth", "more than pinion_teeth (25)", "give 26 to 28",
    ),
    "an edge as large as the tooth": (
        to(pinion_tip_edge_radius_mm="8"), "gear_pair.pinion_tip_edge_radius_mm", "pinion_addendum_mm", "usually 0.2",
    ),
    "a control point beside the gear": (
        to(radius_mm="600"), "wear.control_point.radius_mm", "480 to 560 mm", "a gear radius",
    ),
    "a control point above the tooth": (
        to(height_mm="40"), "wear.control_point.height_mm", "-7.9375 to 6.35 mm", "negative on the dedendum",
    ),
}  # fmt: skip


def test_there_are_many():
    assert len(MALFORMED) >= 60


@pytest.mark.parametrize("kind", MALFORMED)
def test_the_error_tells_field_range_and_way_out(kind):
    change, field, allowed, fix = MALFORMED[kind]
    with pytest.raises(SceneError) as caught:
        parse_scene(change(TEXT), name="mine.toml", check=geometric_problems)
    assert str(caught.value).startswith("mine.toml: ")
    problem = next((problem for problem in caught.value.problems if problem.field == field), None)
    assert problem is not None, str(caught.value)
    assert allowed in problem.allowed
    assert re.search(fix if ".*" in fix else re.escape(fix), problem.fix), problem.fix
    assert str(problem) in str(caught.value)
    assert max(map(len, str(caught.value).splitlines())) < 600

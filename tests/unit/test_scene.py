"""Scenes: every rule of a field and across fields, reported at once; files in and out; changes."""

import dataclasses
import math
import pickle
import tomllib
from dataclasses import FrozenInstanceError, fields
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from semiwear.errors import Problem, SceneError
from semiwear.scene import (
    BodyCoefficients,
    FaceGearPair,
    Material,
    Operation,
    Placement,
    Scene,
    load_scene,
    parse_scene,
    scene_from_dict,
)
from semiwear.scene.schema import SCHEMAS
from tests.scenes import problems_of as problems_when

NAME = "face_gear_25x160"
TEXT = (resources.files("semiwear.scene") / "scenes" / f"{NAME}.toml").read_text(encoding="utf-8")

RULES, TABLES, fields_of = SCHEMAS["face_gear"].rules, SCHEMAS["face_gear"].tables, SCHEMAS["face_gear"].fields_of

REQUIRED_ONLY = """
[gear_pair]
type = "face_gear"
pinion_teeth = 25
shaper_teeth = 28
gear_teeth = 160
module_mm = 6.35
pressure_angle_deg = 25
gear_inner_radius_mm = 480
gear_outer_radius_mm = 560
pinion_face_width_mm = 80

[operation]
pinion_torque_Nm = 1600
"""


@pytest.fixture
def shipped() -> Scene:
    return load_scene(NAME)


def data() -> dict[str, Any]:
    return tomllib.loads(TEXT)


def problems_of(change: dict[str, Any]) -> dict[str, Problem]:
    """Problems by field after writing dotted keys into the shipped scene's tables; None deletes."""
    scene = data()
    for key, value in change.items():
        *path, name = key.split(".")
        table = scene
        for step in path:
            table = table.setdefault(step, {})
        if value is None:
            table.pop(name)
        else:
            table[name] = value
    return problems_when(scene_from_dict, scene)


class TestShippedScene:
    def test_holds_the_papers_data(self, shipped: Scene) -> None:
        pair = shipped.gear_pair
        assert (pair.pinion_teeth, pair.shaper_teeth, pair.gear_teeth) == (25, 28, 160)
        assert (pair.module_mm, pair.pressure_angle_deg, pair.shaft_angle_deg) == (6.35, 25.0, 90.0)
        assert (pair.gear_inner_radius_mm, pair.gear_outer_radius_mm) == (480.0, 560.0)
        radii = (pair.pinion_pitch_radius_mm, pair.shaper_pitch_radius_mm, pair.gear_pitch_radius_mm)
        assert radii == pytest.approx((79.375, 88.9, 508.0))
        assert shipped.reference == "seed_paper"
        assert shipped.wear is not None
        assert shipped.wear.coefficient_mm2_per_N == 1e-13
        assert shipped.wear.worn_bodies == ("gear",)
        assert shipped.wear.until.control_depths_um == tuple(range(5, 61, 5))
        assert shipped.wear.until.meshes is None
        assert shipped.wear.control_point is not None
        assert (shipped.wear.control_point.radius_mm, shipped.wear.control_point.height_mm) == (508.0, -4.0)

    def test_agrees_with_the_defaults_that_it_spells_out(self, shipped: Scene) -> None:
        assert parse_scene(REQUIRED_ONLY).gear_pair == shipped.gear_pair

    def test_every_value_the_paper_leaves_out_is_marked(self) -> None:
        stated = (
            "title", "reference", "type", "pinion_teeth", "shaper_teeth", "gear_teeth", "module_mm",
            "pressure_angle_deg", "shaft_angle_deg", "gear_inner_radius_mm", "gear_outer_radius_mm",
            "pinion_face_width_mm", "coefficient_mm2_per_N", "worn_bodies", "control_depths_um",
            "fidelity", "wear_scheme",
        )  # fmt: skip
        values = [line for line in TEXT.splitlines() if " = " in line and not line.startswith("#")]
        assert len(values) > 30
        for line in values:
            assert ("# inferred: " in line) == (line.split(" = ")[0] not in stated), line


class TestDefaults:
    def test_only_the_required_fields_are_needed(self) -> None:
        scene = parse_scene(REQUIRED_ONLY)
        assert scene.wear is None
        assert scene.title == ""
        assert scene.reference is None
        assert scene.material.pinion == scene.material.gear == Material()
        assert scene.numerics.roll_positions == 24
        assert scene.operation.loaded_flank == "drive"

    def test_derived_defaults_are_numbers(self) -> None:
        pair = parse_scene(REQUIRED_ONLY).gear_pair
        assert pair.pinion_centre_mm == 520.0
        assert pair.pinion_addendum_mm == pair.gear_addendum_mm == 6.35
        assert pair.shaper_addendum_mm == pair.rack_addendum_mm == 7.9375
        assert (pair.shaper_tip_radius_mm, pair.rack_tip_radius_mm) == (1.27, 1.905)
        assert (pair.pinion_bore_radius_mm, pair.gear_rim_thickness_mm) == (50.0, 15.875)

    def test_constructed_pair_resolves_its_defaults(self, shipped: Scene) -> None:
        pair = FaceGearPair(
            type="face_gear",
            pinion_teeth=25,
            shaper_teeth=28,
            gear_teeth=160,
            module_mm=6.35,
            pressure_angle_deg=25,
            gear_inner_radius_mm=480,
            gear_outer_radius_mm=560,
            pinion_face_width_mm=80,
        )
        assert pair == shipped.gear_pair
        # Whole numbers where fractions are kept must not change what is written.
        constructed = Scene(gear_pair=pair, operation=Operation(pinion_torque_Nm=1600))
        assert constructed.to_toml() == parse_scene(REQUIRED_ONLY).to_toml()

    def test_units_are_in_the_names(self) -> None:
        bare = {
            "teeth",
            "ratio",
            "meshes",
            "hours",
            "iterations",
            "steps",
            "pairs",
            "positions",
            "slices",
            "threads",
            "width",
            "points",
            "harmonics",
            "accuracy",
            "coefficient",
            "lambda",
            "strength",
            "exponent",
            "shares",
            "1e10",
            "factor",
            "safety",
            "stage",
            "film",
        }
        units = {"mm", "um", "deg", "MPa", "Nm", "N", "C", "GPa", "HV", "kN", "kNm", "kgK", "m3", "mK", "mPas", "s"}
        units |= {"mol", "mrad", "rpm"}
        for key, rule in RULES.items():
            if rule.read.__name__ in ("number", "numbers", "whole"):
                last = key.split("_")[-1].rpartition(".")[2]
                assert last in bare | units, key


OUT_OF_RANGE = [
    ("gear_pair.type", "bevel"),
    ("gear_pair.pinion_teeth", 11),
    ("gear_pair.shaper_teeth", 5),
    ("gear_pair.gear_teeth", -160),
    ("gear_pair.gear_teeth", 10**400),
    ("gear_pair.module_mm", 0),
    ("gear_pair.module_mm", -6.35),
    ("gear_pair.pressure_angle_deg", 9.9),
    ("gear_pair.pressure_angle_deg", 35.1),
    ("gear_pair.gear_inner_radius_mm", 0),
    ("gear_pair.gear_outer_radius_mm", -560),
    ("gear_pair.pinion_face_width_mm", 0.0),
    ("gear_pair.pinion_centre_mm", -1),
    ("gear_pair.pinion_addendum_mm", 0),
    ("gear_pair.gear_addendum_mm", 0),
    ("gear_pair.shaper_addendum_mm", 0),
    ("gear_pair.rack_addendum_mm", -1),
    ("gear_pair.shaper_tip_radius_mm", -0.1),
    ("gear_pair.rack_tip_radius_mm", -0.1),
    ("gear_pair.pinion_tip_edge_radius_mm", -0.1),
    ("gear_pair.gear_tip_edge_radius_mm", -0.1),
    ("gear_pair.pinion_end_edge_radius_mm", -0.1),
    ("gear_pair.gear_end_edge_radius_mm", -0.1),
    ("gear_pair.pinion_bore_radius_mm", 0),
    ("gear_pair.gear_rim_thickness_mm", 0),
    ("material.pinion.youngs_modulus_MPa", 0),
    ("material.gear.youngs_modulus_MPa", -1),
    ("material.pinion.poissons_ratio", 0.5),
    ("material.gear.poissons_ratio", 0),
    ("operation.pinion_torque_Nm", 0),
    ("operation.pinion_torque_Nm", -1600),
    ("operation.loaded_flank", "left"),
    ("operation.pinion_speed_rpm", 0),
    ("wear.coefficient_mm2_per_N", 0),
    ("wear.coefficient_mm2_per_N", {"pinion": 0, "gear": 1e-13}),
    ("wear.worn_bodies", []),
    ("wear.worn_bodies", ["gear", "gear"]),
    ("wear.until.control_depths_um", []),
    ("wear.until.control_depths_um", [5, 5]),
    ("wear.until.control_depths_um", [10, 5]),
    ("wear.until.control_depths_um", [0, 5]),
    ("reference", "another_paper"),
    ("numerics.wear_scheme", "midpoint"),
    ("numerics.wear_steps", 0),
    ("numerics.roll_positions", 7),
    ("numerics.face_slices", 6),
    ("numerics.profile_points", 20),
    ("numerics.threads", 0),
    ("numerics.tooth_pairs", 0),
    ("numerics.tooth_pairs", 8),
    ("numerics.harmonics", 0),
    ("numerics.max_iterations", 0),
]

WRONG_TYPE = [
    ("gear_pair.module_mm", "6.35"),
    ("gear_pair.module_mm", True),
    ("gear_pair.module_mm", [6.35]),
    ("gear_pair.module_mm", {"mm": 6.35}),
    ("gear_pair.module_mm", math.nan),
    ("gear_pair.module_mm", math.inf),
    ("gear_pair.module_mm", 10**400),
    ("gear_pair.gear_teeth", 160.5),
    ("gear_pair.gear_teeth", False),
    ("gear_pair.gear_teeth", math.nan),
    ("wear.control_point.height_mm", -math.inf),
    ("wear.until.control_depths_um", 60),
    ("wear.until.control_depths_um", [5, "10"]),
    ("wear.until.control_depths_um", [5, math.nan]),
    ("wear.coefficient_mm2_per_N", {"gear": None}),
    ("wear.coefficient_mm2_per_N", [1e-13, 1e-13]),
    ("wear.worn_bodies", "gear"),
    ("wear.worn_bodies", [1]),
    ("numerics.wear_steps", "many"),
    ("numerics.wear_steps", 1.5),
    ("numerics.fidelity", 1),
    ("title", 25),
    ("gear_pair", 5),
    ("material", "steel"),
    ("material.gear", ["steel"]),
    ("operation", [{"pinion_torque_Nm": 1600}]),
    ("wear.until", 60),
    ("wear.control_point", [508, -4]),
]


# what else is refused, and words of the way out
WAYS_OUT = [
    ("numerics.tooth_compliance", "tables/influence.h5", ".nc"),
    ("numerics.tooth_compliance", "prisms", 'did you mean "prism"'),
    ("numerics.wear_mapping", "marching", '"marched"'),
    ("wear.worn_bodies", ["gear", "pinoin"], 'give ["pinion", "gear"]'),
    ("wear.coefficient_mm2_per_N", {}, "pinion = ..., gear = ..."),
    ("wear.coefficient_mm2_per_N", {"geer": 1e-13}, "not geer"),
    ("wear.coefficient_mm2_per_N", {"gear": "1e-13"}, "without quotes"),
    ("operation.pinion_speed_rpm", -1500, "without a sign"),
    ("gear_pair.shaft_angle_deg", 80, "not available yet; only 90"),
    ("operation.loaded_flank", "drvie", 'did you mean "drive"'),
    ("wear.until.control_depths_um", [10, 5, 5], "[5.0, 10.0]"),
]


class TestFieldRules:
    @pytest.mark.parametrize(
        ("key", "value", "fix"), [*((key, value, "") for key, value in OUT_OF_RANGE + WRONG_TYPE), *WAYS_OUT]
    )
    def test_refused_alone_with_range_and_fix(self, key: str, value: Any, fix: str) -> None:
        problems = problems_of({key: value})
        assert list(problems) == [key]
        assert problems[key].value is not None
        assert fix in problems[key].fix

    @pytest.mark.parametrize(
        ("key", "value"),
        [
            ("gear_pair.pressure_angle_deg", 22.5),
            ("gear_pair.gear_tip_edge_radius_mm", 0),
            ("gear_pair.shaper_tip_radius_mm", 0),
            ("numerics.tooth_pairs", 7),
            ("numerics.wear_steps", 1),
            ("numerics.roll_positions", 8),
            ("numerics.face_slices", 7),
            ("numerics.profile_points", 21),
            ("numerics.tooth_compliance", "rigid"),
            ("numerics.wear_scheme", "explicit"),
            ("operation.loaded_flank", "coast"),
            ("wear.until.control_depths_um", [60]),
        ],
    )
    def test_limits_of_the_range_are_accepted(self, shipped: Scene, key: str, value: Any) -> None:
        assert shipped.replace({key: value}) != shipped

    def test_integral_float_counts_as_whole(self, shipped: Scene) -> None:
        scene = shipped.replace({"gear_pair.pinion_teeth": 25.0})
        assert scene == shipped
        assert isinstance(scene.gear_pair.pinion_teeth, int)

    def test_missing_required_fields_are_all_named(self) -> None:
        missing = problems_when(parse_scene, 'gear_pair.type = "face_gear"')
        assert set(missing) == {
            *(f"gear_pair.{line.split(' = ')[0]}" for line in REQUIRED_ONLY.splitlines()[2:11]),
            "operation.pinion_torque_Nm",
        } - {"gear_pair.type"}
        assert all("needed by [" in problem.fix for problem in missing.values())

    def test_an_empty_scene_is_asked_for_its_kind_of_pair_first(self) -> None:
        assert set(problems_when(parse_scene, "")) == {"gear_pair.type", "operation.pinion_torque_Nm"}


INNER, OUTER = "gear_pair.gear_inner_radius_mm", "gear_pair.gear_outer_radius_mm"
# every problem of a change, and words of what is allowed or of the way out
TOGETHER: dict[str, tuple[dict[str, Any], dict[str, str]]] = {
    "every kind at once": (
        {
            "gear_pair.module_mm": None,
            "gear_pair.shaper_teeth": 25,
            "gear_pair.pressure_angle_deg": math.nan,
            "operation.pinion_torque_Nm": "1600",
            "material.gear.poissons_ratio": 0.7,
            "wear.until.meshes": 1e9,
            "numerics.harmnics": 12,
            "effects.frictoin": {},
        },
        dict.fromkeys(
            [
                "gear_pair.module_mm",
                "gear_pair.shaper_teeth",
                "gear_pair.pressure_angle_deg",
                "operation.pinion_torque_Nm",
                "material.gear.poissons_ratio",
                "wear.until",
                "numerics.harmnics",
                "effects.frictoin",
            ],
            "",
        ),
    ),
    # names
    "a misspelled field that is needed": (
        {"gear_pair.module_mm": None, "gear_pair.modul_mm": 6.35},
        {"gear_pair.modul_mm": "did you mean module_mm? It is missing"},
    ),
    "the value of a misspelled field": (
        {"gear_pair.module_mm": None, "gear_pair.modul_mm": -6.35},
        {"gear_pair.modul_mm": "module_mm", "gear_pair.module_mm": "greater than 0"},
    ),
    "a misspelled field that is not needed": (
        {"numerics.max_iteration": 5},
        {"numerics.max_iteration": "did you mean max_iterations?"},
    ),
    "a misspelled table and a field in it": (
        {"gear_pair": None, "gear_pear": data()["gear_pair"] | {"module_mm": 0}},
        {"gear_pear": "did you mean gear_pair?", "gear_pair.module_mm": ""},
    ),
    "a field in another table": (
        {"operation.pinion_torque_Nm": None, "gear_pair.pinion_torque_Nm": 1600},
        {"gear_pair.pinion_torque_Nm": "operation.pinion_torque_Nm"},
    ),
    "a name unlike any": ({"operation.zzz": 1}, {"operation.zzz": "pinion_torque_Nm, loaded_flank"}),
    "an empty name": ({"": 1}, {'""': ""}),
    # fields that do not fit one another
    "radii like diameters": (
        {INNER: 960.0, OUTER: 1120.0},
        dict.fromkeys([INNER, OUTER], "look like diameters: the pitch radius is 508 mm; give 480 and 560"),
    ),
    "halved radii": (
        {INNER: 240.0, OUTER: 280.0},
        dict.fromkeys([INNER, OUTER], "the pitch radius is 508 mm; give 480 and 560"),
    ),
    "a pitch radius outside": ({"gear_pair.gear_teeth": 145}, {INNER: "the pitch radius is 460.375 mm"}),
    "swapped radii": ({INNER: 560, OUTER: 480}, {OUTER: "swap them: 480 and 560"}),
    "a shaper as small as the pinion": ({"gear_pair.shaper_teeth": 25}, {"gear_pair.shaper_teeth": "26 to 28"}),
    "a smaller shaper": ({"gear_pair.shaper_teeth": 24}, {"gear_pair.shaper_teeth": "26 to 28"}),
    "a crest rounder than round": ({"gear_pair.rack_tip_radius_mm": 2.019}, {"gear_pair.rack_tip_radius_mm": "2.01"}),
    "a bore at the root": (
        {"gear_pair.pinion_bore_radius_mm": 71.4375},
        {"gear_pair.pinion_bore_radius_mm": "71.4375"},
    ),
    "a control point where a narrow pinion does not reach": (
        {"gear_pair.pinion_face_width_mm": 30, "wear.control_point.radius_mm": 490},
        {"wear.control_point.radius_mm": ""},
    ),
    "two ends of the run": ({"wear.until.meshes": 1e9}, {"wear.until": ""}),
    "no end of the run": ({"wear.until.control_depths_um": None}, {"wear.until": "needed by [wear]"}),
    "no table of the end": ({"wear.until": None}, {"wear.until": "needed by [wear]"}),
    "depths without a control point": (
        {"wear.control_point": None},
        {"wear.control_point": "needed by [wear.until] control_depths_um"},
    ),
    "half a control point": ({"wear.control_point.height_mm": None}, {"wear.control_point.height_mm": ""}),
    "wear without a coefficient": ({"wear.coefficient_mm2_per_N": None}, {"wear.coefficient_mm2_per_N": ""}),
    "a control point on the body that does not wear": (
        {"wear.worn_bodies": ["pinion"], "wear.control_point.body": "gear"},
        {"wear.control_point.body": 'one of wear.worn_bodies: "pinion" add "gear"'},
    ),
    "so it is in a run until meshes": (
        {
            "wear.worn_bodies": ["pinion"],
            "wear.control_point.body": "gear",
            "wear.until.control_depths_um": None,
            "wear.until.meshes": 1e9,
        },
        {"wear.control_point.body": 'one of wear.worn_bodies: "pinion" add "gear"'},
    ),
    "marched wear of both bodies": (
        {
            "numerics.fidelity": "patch",
            "numerics.wear_mapping": "marched",
            "wear.worn_bodies": ["pinion", "gear"],
        },
        {"numerics.wear_mapping": "wear.worn_bodies"},
    ),
}


class TestTogether:
    @pytest.mark.parametrize("name", TOGETHER)
    def test_all_problems_are_told_at_once_and_no_other(self, name: str) -> None:
        change, expected = TOGETHER[name]
        problems = problems_of(change)
        assert set(problems) == set(expected)
        for field, words in expected.items():
            assert words in f"{problems[field].allowed} {problems[field].fix}"

    def test_the_value_of_a_misspelled_field_is_told_and_a_missing_one_has_none(self) -> None:
        misspelled, missing = TOGETHER["the value of a misspelled field"][0], {"gear_pair.module_mm": None}
        assert problems_of(misspelled)["gear_pair.module_mm"].value == -6.35
        assert problems_of(missing)["gear_pair.module_mm"].value is None

    def test_message_names_scene_field_value_range_and_fix(self) -> None:
        with pytest.raises(SceneError, match="my scene: 1 problem") as caught:
            parse_scene(TEXT.replace("pinion_torque_Nm = 1600", "pinion_torque_Nm = -7"), name="my scene")
        message = str(caught.value)
        assert "operation.pinion_torque_Nm: found -7; allowed: greater than 0 N m -> " in message

    def test_quoted_dotted_name_is_no_path(self) -> None:
        with pytest.raises(SceneError):
            scene_from_dict(data() | {"operation.pinion_torque_Nm": 1.0})

    def test_diameter_instead_of_radius_is_recognised_under_its_own_name(self) -> None:
        change = {INNER: None, "gear_pair.gear_inner_diameter_mm": 480}
        assert "gear_inner_radius_mm" in problems_of(change)["gear_pair.gear_inner_diameter_mm"].fix

    @pytest.mark.parametrize(
        ("change", "key", "limit"),
        [
            # At 20 degrees and 1.25 m the crest of module 1 is fully round at 0.4719.
            ({"gear_pair.pressure_angle_deg": 20}, "gear_pair.rack_tip_radius_mm", 0.4719 * 6.35),
            # half the tooth thickness of the rack, pi m/4, over tan(25 deg)
            ({}, "gear_pair.rack_addendum_mm", 10.6953),
        ],
    )
    def test_limits_of_the_rack(self, change: dict[str, Any], key: str, limit: float) -> None:
        problem = problems_of(change | {key: 11})[key]
        assert float(problem.allowed.split("to ")[1].removesuffix(" mm")) == pytest.approx(limit, abs=1e-3)
        assert "cross" in problem.fix or "addendum" not in key

    @pytest.mark.parametrize(
        ("key", "value", "within"),
        [
            ("gear_pair.rack_tip_radius_mm", 2.019, 2.018),  # 2.0181 mm: fully round at 1.25 m and 25 degrees
            ("gear_pair.pinion_bore_radius_mm", 71.4375, 71.4),
            ("gear_pair.pinion_addendum_mm", 7.9375, 7.85),
            ("gear_pair.gear_addendum_mm", 7.9375, 7.85),
            ("gear_pair.pinion_tip_edge_radius_mm", 6.35, 6.28),
            ("gear_pair.gear_tip_edge_radius_mm", 6.35, 6.28),
            ("gear_pair.pinion_end_edge_radius_mm", 40, 39.6),
            ("gear_pair.gear_end_edge_radius_mm", 40, 39.6),
            ("wear.control_point.radius_mm", 479.9, 508.0),
            ("wear.control_point.radius_mm", 560.1, 508.0),
            ("wear.control_point.height_mm", -7.94, -3.0),
            ("wear.control_point.height_mm", 6.36, -3.0),
        ],
    )
    def test_limit_set_by_other_fields(self, shipped: Scene, key: str, value: float, within: float) -> None:
        assert list(problems_of({key: value})) == [key]
        shipped.replace({key: within})

    @pytest.mark.parametrize("centre", [460.0, 470 - 2.01, 550.0, 700.0])
    def test_pinion_covers_the_pitch_radius(self, centre: float) -> None:
        problem = problems_of({"gear_pair.pinion_centre_mm": centre})["gear_pair.pinion_centre_mm"]
        assert problem.allowed == "468 to 548 mm: the pinion's face must cover the pitch radius"
        assert problem.fix == "give 520, the middle of the gear's face"

    def test_meshes_do_without_the_control_point(self, shipped: Scene) -> None:
        scene = shipped.replace({"wear.until.meshes": 1e9, "wear.control_point": None})
        assert scene.wear is not None
        assert scene.wear.control_point is None


class TestWornBodies:
    METHOD = {"wear.until.meshes": 1e9, "wear.control_point": None}  # noqa: RUF012

    @pytest.mark.parametrize(
        ("given", "kept"),
        [(["gear", "pinion"], ("pinion", "gear")), (["pinion"], ("pinion",)), (["gear"], ("gear",))],
    )
    def test_any_of_both(self, shipped: Scene, given: list[str], kept: tuple[str, ...]) -> None:
        scene = shipped.replace({**self.METHOD, "wear.worn_bodies": given})
        assert scene.wear is not None
        assert scene.wear.worn_bodies == kept
        assert parse_scene(scene.to_toml()) == scene

    def test_one_coefficient_serves_both(self, shipped: Scene) -> None:
        assert shipped.wear is not None
        assert shipped.wear.coefficient("pinion") == shipped.wear.coefficient("gear") == 1e-13
        with pytest.raises(SceneError, match='"pinion" or "gear"'):
            shipped.wear.coefficient("wheel")

    def test_coefficients_of_bodies(self, shipped: Scene) -> None:
        given = {"pinion": 2e-14, "gear": 1e-13}
        scene = shipped.replace({"wear.coefficient_mm2_per_N": given, "wear.worn_bodies": ["pinion", "gear"]})
        assert scene.wear is not None
        assert scene.wear.coefficient_mm2_per_N == BodyCoefficients(pinion=2e-14, gear=1e-13)
        assert (scene.wear.coefficient("pinion"), scene.wear.coefficient("gear")) == (2e-14, 1e-13)
        assert "coefficient_mm2_per_N = {pinion = 2e-14, gear = 1e-13}\n" in scene.to_toml()
        assert scene.to_dict()["wear"]["coefficient_mm2_per_N"] == given
        assert parse_scene(scene.to_toml()) == scene_from_dict(scene.to_dict()) == scene
        assert hash(parse_scene(scene.to_toml())) == hash(scene)
        assert scene.replace({"wear.coefficient_mm2_per_N": BodyCoefficients(**given)}) == scene
        assert scene.replace({"wear.coefficient_mm2_per_N": 1e-13, "wear.worn_bodies": None}) == shipped

    def test_body_that_does_not_wear_needs_no_coefficient(self, shipped: Scene) -> None:
        scene = shipped.replace({"wear.coefficient_mm2_per_N": {"gear": 1e-13}})
        assert parse_scene(scene.to_toml()) == scene
        assert scene.wear is not None
        with pytest.raises(SceneError, match=r"wear\.coefficient_mm2_per_N\.pinion: missing"):
            scene.wear.coefficient("pinion")

    def test_a_header_does_as_well_as_braces(self, shipped: Scene) -> None:
        text = TEXT.replace("coefficient_mm2_per_N = 1e-13", "").replace(
            "[wear.until]", "[wear.coefficient_mm2_per_N]\ngear = 1e-13\n[wear.until]"
        )
        assert parse_scene(text) == shipped.replace({"wear.coefficient_mm2_per_N": {"gear": 1e-13}})


class TestChecker:
    LIMIT = Problem("gear_pair.gear_outer_radius_mm", 560.0, "up to 550 mm", "teeth are pointed beyond")

    def test_its_problems_are_raised(self) -> None:
        with pytest.raises(SceneError) as caught:
            load_scene(NAME, check=lambda scene: [self.LIMIT])
        assert caught.value.problems == (self.LIMIT,)

    def test_its_problems_join_those_of_rules_and_names(self) -> None:
        text = TEXT.replace("shaper_teeth = 28", "shaper_teeth = 25") + "\nmax_iteration = 5\n"
        found = problems_when(parse_scene, text, check=lambda scene: [self.LIMIT])
        assert set(found) == {"gear_pair.shaper_teeth", "numerics.max_iteration", self.LIMIT.field}

    def test_not_run_on_an_incomplete_scene(self) -> None:
        def check(scene: Scene) -> list[Problem]:
            raise AssertionError("must not run")

        with pytest.raises(SceneError):
            parse_scene(TEXT.replace("module_mm = 6.35", "module_mm = -6.35"), check=check)

    def test_failure_on_a_conflicting_scene_is_forgiven_but_not_on_a_sound_one(self) -> None:
        def check(scene: Scene) -> list[Problem]:
            raise ZeroDivisionError

        text = TEXT.replace("shaper_teeth = 28", "shaper_teeth = 25")
        assert list(problems_when(parse_scene, text, check=check)) == ["gear_pair.shaper_teeth"]
        with pytest.raises(ZeroDivisionError):
            parse_scene(TEXT, check=check)

    def test_field_already_reported_is_not_reported_twice(self) -> None:
        text = TEXT.replace("gear_outer_radius_mm = 560", "gear_outer_radius_mm = 500")
        assert list(problems_when(parse_scene, text, check=lambda scene: [self.LIMIT])) == [self.LIMIT.field]

    def test_is_remembered_by_replace_and_nowhere_else(self, shipped: Scene) -> None:
        def check(scene: Scene) -> list[Problem]:
            return [self.LIMIT] if scene.gear_pair.gear_outer_radius_mm > 560.0 else []

        scene = load_scene(NAME, check=check)
        assert scene == shipped
        assert hash(scene) == hash(shipped)
        assert scene.sha256 == shipped.sha256
        assert repr(scene) == repr(shipped)
        scene = scene.replace({"operation.pinion_torque_Nm": 5})
        with pytest.raises(SceneError, match="pointed"):
            scene.replace({"gear_pair.gear_outer_radius_mm": 570})
        assert shipped.replace({"gear_pair.gear_outer_radius_mm": 570})


class TestFiles:
    def test_round_trip_of_the_least_scene(self) -> None:
        scene = parse_scene(REQUIRED_ONLY)
        assert parse_scene(scene.to_toml()) == scene
        assert "rack_tip_radius_mm = 1.905" in scene.to_toml()

    def test_hash_follows_content(self, shipped: Scene) -> None:
        assert shipped.replace({"title": "other"}).sha256 != shipped.sha256
        assert (
            shipped.replace({"gear_pair.gear_tip_edge_radius_mm": 0.0}).sha256
            == shipped.replace({"gear_pair.gear_tip_edge_radius_mm": -0.0}).sha256
        )

    @pytest.mark.parametrize(
        "title", ['a "quoted" \\ title', "line\nbreak\ttab\r", "\x00\x1f\x7f", "Zähne é 歯 𝛼", "# [x]"]
    )
    def test_awkward_titles_survive(self, shipped: Scene, title: str) -> None:
        assert parse_scene(shipped.replace({"title": title}).to_toml()).title == title

    def test_title_that_utf8_cannot_hold(self, shipped: Scene) -> None:
        with pytest.raises(SceneError, match="UTF-8"):
            shipped.replace({"title": "\ud800"})

    def test_load_from_path_in_all_forms(self, shipped: Scene, tmp_path: Path) -> None:
        path = tmp_path / "mine.toml"
        path.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())  # with a byte order mark
        assert load_scene(path) == load_scene(str(path)) == shipped

    def test_unknown_name_lists_the_shipped_ones(self) -> None:
        with pytest.raises(SceneError) as caught:
            load_scene("facegear_25x160")
        assert f'did you mean "{NAME}"?' in str(caught.value)
        with pytest.raises(SceneError, match=NAME):
            load_scene("zzz")

    @pytest.mark.parametrize("content", [b"\xff\xfe\x00", None])
    def test_unreadable_file(self, tmp_path: Path, content: bytes | None) -> None:
        path = tmp_path / "mine.toml"
        path.mkdir() if content is None else path.write_bytes(content)
        with pytest.raises(SceneError):
            load_scene(path)

    def test_name_that_no_file_can_have(self) -> None:
        with pytest.raises(SceneError):
            load_scene("\x00")

    def test_syntax_error_names_the_line(self) -> None:
        text = TEXT.replace("gear_teeth = 160\n", "gear_teeth = \n")
        number = next(k for k, line in enumerate(text.splitlines(), 1) if line == "gear_teeth = ")
        with pytest.raises(SceneError) as caught:
            parse_scene(text, name="mine.toml")
        assert caught.value.problems[0].field == f"line {number}"
        assert "mine.toml" in str(caught.value)

    @pytest.mark.parametrize("value", ["9" * 5000, "[" * 5000, "0x" + "f" * 9000, "[1", '"'])
    def test_values_that_break_parsers_are_problems(self, value: str) -> None:
        with pytest.raises(SceneError) as caught:
            parse_scene(f"title = {value}")
        assert len(str(caught.value)) < 20_000


class TestReplace:
    def test_is_checked(self, shipped: Scene) -> None:
        change = {"operation.pinion_torque_Nm": -1, "gear_pair.shaper_teeth": 20}
        assert set(problems_when(shipped.replace, change)) == set(change)

    @pytest.mark.parametrize(
        ("key", "meant"),
        [
            ("operation.torque_Nm", "pinion_torque_Nm"),
            ("operatoin.pinion_torque_Nm", "operation.pinion_torque_Nm"),
            ("gear_pair.modul_mm", "module_mm"),
            ("pinion_torque_Nm", "operation.pinion_torque_Nm"),
            ("effects.hub", "remove it"),
            ("effects.frictoin.coefficient", "effects.friction"),
        ],
    )
    @pytest.mark.parametrize("value", [5.0, None])
    def test_unknown_key(self, shipped: Scene, key: str, meant: str, value: float | None) -> None:
        problems = problems_when(shipped.replace, {key: value, "operation.pinion_torque_Nm": -3})
        assert set(problems) == {key, "operation.pinion_torque_Nm"}
        assert meant in problems[key].fix

    @pytest.mark.parametrize("key", ["", ".", "wear.", ".wear", "gear_pair..module_mm", 5])
    def test_key_that_is_none(self, shipped: Scene, key: Any) -> None:
        with pytest.raises(SceneError):
            shipped.replace({key: 5.0})

    def test_meshes_and_depths_exclude_each_other(self, shipped: Scene) -> None:
        by_meshes = shipped.replace({"wear.until.meshes": 1e9})
        assert by_meshes.wear is not None
        assert by_meshes.wear.until.meshes == 1e9
        assert by_meshes.wear.until.control_depths_um is None
        by_depths = by_meshes.replace({"wear.until.control_depths_um": [5, 10]})
        assert by_depths.wear is not None
        assert by_depths.wear.until.meshes is None
        assert by_depths.wear.until.control_depths_um == (5.0, 10.0)

    def test_meshes_and_depths_both_set_at_once(self, shipped: Scene) -> None:
        with pytest.raises(SceneError, match="exactly one"):
            shipped.replace({"wear.until.meshes": 1e9, "wear.until.control_depths_um": [5]})

    def test_none_brings_no_table(self, shipped: Scene) -> None:
        bare = shipped.replace({"wear": None})
        assert bare.replace({"wear.control_point": None, "wear.until.meshes": None}) == bare

    def test_none_goes_back_to_the_default(self, shipped: Scene) -> None:
        changed = shipped.replace({"gear_pair.rack_tip_radius_mm": 1.5, "numerics.harmonics": 5})
        back = changed.replace({"gear_pair.rack_tip_radius_mm": None, "numerics.harmonics": None})
        assert back == shipped

    def test_callers_table_is_not_changed(self, shipped: Scene) -> None:
        until = {"meshes": 1e9}
        shipped.replace({"wear.until": until, "wear.until.control_depths_um": [5]})
        assert until == {"meshes": 1e9}

    def test_derived_defaults_follow_and_explicit_values_stay(self) -> None:
        scene = parse_scene(REQUIRED_ONLY).replace({"gear_pair.gear_addendum_mm": 6.0})
        scene = scene.replace({"operation.pinion_torque_Nm": 5})  # what was explicit is remembered
        bigger = scene.replace(
            {
                "gear_pair.module_mm": 7.0,
                "gear_pair.gear_inner_radius_mm": 530,
                "gear_pair.gear_outer_radius_mm": 616,
            }
        ).gear_pair
        assert bigger.gear_addendum_mm == 6.0
        assert bigger.pinion_addendum_mm == 7.0
        assert bigger.rack_tip_radius_mm == 2.1
        assert bigger.pinion_centre_mm == 573.0
        assert bigger.pinion_bore_radius_mm == pytest.approx(50.0 * 7.0 / 6.35)  # in proportion, not to two digits

    def test_values_spelled_out_in_a_file_stay(self, shipped: Scene) -> None:
        changed = shipped.replace({"gear_pair.pressure_angle_deg": 20, "gear_pair.module_mm": 6.4})
        assert changed.gear_pair.gear_addendum_mm == 6.35

    def test_dataclasses_replace_is_not_forgotten(self, shipped: Scene) -> None:
        scene = parse_scene(REQUIRED_ONLY)
        changed = dataclasses.replace(scene, operation=Operation(pinion_torque_Nm=7.0))
        assert changed.replace({"title": "x"}).operation.pinion_torque_Nm == 7.0

    def test_arrays_are_accepted(self, shipped: Scene) -> None:
        numpy = pytest.importorskip("numpy")
        changed = shipped.replace(
            {
                "operation.pinion_torque_Nm": numpy.float32(800),
                "numerics.roll_positions": numpy.int64(12),
                "wear.until.control_depths_um": numpy.linspace(5, 60, 12),
            }
        )
        assert changed == shipped.replace({"operation.pinion_torque_Nm": 800, "numerics.roll_positions": 12})
        assert type(changed.numerics.roll_positions) is int
        assert parse_scene(changed.to_toml()) == changed


class TestImmutability:
    def test_fields_cannot_be_set(self, shipped: Scene) -> None:
        for owner, name in [(shipped, "title"), (shipped.gear_pair, "module_mm"), (shipped.wear, "until")]:
            with pytest.raises(FrozenInstanceError):
                setattr(owner, name, 1)

    def test_lists_become_tuples(self, shipped: Scene) -> None:
        assert shipped.wear is not None
        assert isinstance(shipped.wear.until.control_depths_um, tuple)
        assert isinstance(shipped.wear.worn_bodies, tuple)

    def test_dict_is_a_copy(self, shipped: Scene) -> None:
        before = shipped.to_toml()
        shipped.to_dict()["wear"]["until"]["control_depths_um"].clear()
        assert shipped.to_toml() == before

    def test_scenes_travel_between_processes(self, shipped: Scene) -> None:
        assert pickle.loads(pickle.dumps(shipped)) == shipped


class TestPlacement:
    def test_default_is_aligned(self) -> None:
        assert Placement().is_aligned

    @pytest.mark.parametrize("name", [entry.name for entry in fields(Placement)])
    def test_any_displacement_is_not(self, name: str) -> None:
        assert not Placement(**{name: 1e-9}).is_aligned

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, "0.1", True, None])
    def test_only_finite_numbers(self, value: Any) -> None:
        problems = problems_when(Placement, offset_mm=value, pinion_slope_mrad=value)
        assert list(problems) == ["placement.offset_mm", "placement.pinion_slope_mrad"]

    def test_whole_numbers_become_floats(self) -> None:
        assert isinstance(Placement(offset_mm=1).offset_mm, float)


@pytest.mark.parametrize(
    ("inner", "outer", "words"),
    [
        # the pitch radius is 508 mm; as diameters and as halved radii the face just holds it, or just does not
        (960.0, 1018.0, "these look like diameters: the pitch radius is 508 mm; give 480 and 509"),
        (960.0, 1014.0, "correct the radii, the module or the teeth"),
        (1014.0, 1120.0, "give 507 and 560"),
        (1018.0, 1120.0, "correct the radii, the module or the teeth"),
        (
            240.0,
            280.0,
            "halved radii (the paper calls its radii diameters): the pitch radius is 508 mm; give 480 and 560",
        ),
        (253.0, 280.0, "give 506 and 560"),
        (255.0, 280.0, "correct the radii, the module or the teeth"),
        (240.0, 253.0, "correct the radii, the module or the teeth"),
    ],
)
def test_radii_of_another_size_are_recognised(inner, outer, words):
    problems = problems_when(load_scene(NAME).replace, {INNER: inner, OUTER: outer})
    fixes = [problem.fix for field, problem in problems.items() if "radius_mm" in field]
    assert fixes and all(words in fix for fix in fixes), fixes

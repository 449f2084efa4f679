"""What tables of failure modes refuse, and what they say of it."""

import tomllib
from pathlib import Path

import pytest

import semiwear as sw
from tests.scenes import problems_of
from tests.strategies.oil_and_case import OIL

SPUR = sw.load_scene("spur_fzg_c").replace({"operation.pinion_speed_rpm": 1500.0})
_LIMITS = {f"{body}_{name}" for body in ("pinion", "gear") for name in ("limit_MPa", "life_curve")}
REQUIRED = {
    "pitting": {*_LIMITS, "viscosity_40_mm2_per_s", "roughness_Rz_um"},
    "bending": {*_LIMITS, "root_roughness_Rz_um"},
    "micropitting": {*OIL, "bulk_temperature_C", "roughness_Ra_um", "load_stage"},
    "scuffing": {*OIL, "oil_temperature_C", "oil_supply", "load_stage", "structural_factor"},
    "flank_fracture": {
        f"{body}_{name}"
        for body in ("pinion", "gear")
        for name in ("core_hardness_HV", "surface_hardness_HV", "case_depth_mm")
    },
}


@pytest.mark.parametrize("mode", REQUIRED)
def test_missing_data_are_told_all_at_once_with_their_usual_range(mode):
    problems = problems_of(SPUR.replace, {f"effects.{mode}": {}})
    own = {field.rpartition(".")[2] for field in problems if field.startswith(f"effects.{mode}.")}
    assert own == REQUIRED[mode]
    for field, problem in problems.items():
        if field.startswith(f"effects.{mode}.") and not field.endswith(("family", "oil_supply", "life_curve")):
            assert "; usual" in problem.allowed, field


@pytest.mark.parametrize(
    ("mode", "given", "field"),
    [
        ("pitting", {"film_factors": "given"}, "film_factor"),
        ("micropitting", {"limit": "given"}, "permissible_film"),
    ],
)
def test_what_another_field_asks_for_is_told_with_its_usual_range(mode, given, field):
    problem = problems_of(SPUR.replace, {f"effects.{mode}": given})[f"effects.{mode}.{field}"]
    assert problem.value is None and "; usual: " in problem.allowed


def test_film_and_heat_need_speed_and_flash_temperature():
    slow = SPUR.replace({"operation.pinion_speed_rpm": None})
    problems = problems_of(slow.replace, {"effects.scuffing": {}})
    assert {"operation.pinion_speed_rpm", "effects.flash_temperature"} <= set(problems)


@pytest.mark.parametrize("mode", ["micropitting", "scuffing"])
def test_oil_that_thickens_with_heat_is_refused(mode):
    problems = problems_of(
        SPUR.replace,
        {f"effects.{mode}": OIL | {"viscosity_100_mm2_per_s": 300.0}},
    )
    assert "below viscosity_40_mm2_per_s (220)" in problems[f"effects.{mode}.viscosity_100_mm2_per_s"].allowed


def test_a_hardness_for_every_depth():
    table = {"hardness_profile": "table"}
    for body in ("pinion", "gear"):
        table |= {f"{body}_core_hardness_HV": 400.0, f"{body}_hardness_depths_mm": [0.1, 0.5, 1.0]}
    table |= {"pinion_hardness_HV": [700.0, 600.0, 420.0], "gear_hardness_HV": [700.0, 600.0]}
    problems = problems_of(SPUR.replace, {"effects.flank_fracture": table})
    assert set(problems) == {"effects.flank_fracture.gear_hardness_HV"}
    falling = {"effects.flank_fracture": table | {"pinion_hardness_depths_mm": [0.5, 0.1, 1.0]}}
    assert "effects.flank_fracture.pinion_hardness_depths_mm" in problems_of(SPUR.replace, falling)


def test_a_given_film_needs_no_load_stage():
    own = OIL | {"bulk_temperature_C": 90.0, "roughness_Ra_um": 0.4, "limit": "given"}
    assert set(problems_of(SPUR.replace, {"effects.flash_temperature": {}, "effects.micropitting": own})) == {
        "effects.micropitting.permissible_film"
    }
    SPUR.replace({"effects.flash_temperature": {}, "effects.micropitting": own | {"permissible_film": 0.2}})


def test_example_of_the_docs_is_a_scene():
    text = (Path(sw.__file__).parents[1] / "docs" / "failure_modes.md").read_text(encoding="utf-8")
    example = tomllib.loads(text.split("```toml\n", 1)[1].split("```", 1)[0])
    scene = SPUR.replace({"operation.pinion_speed_rpm": example["operation"]["pinion_speed_rpm"]})
    rated = scene.replace({f"effects.{name}": table for name, table in example["effects"].items()})
    assert {name for name, _ in rated.effects.present()} == {"flash_temperature", *example["effects"]}
    assert set(REQUIRED) - {"pitting", "bending"} <= set(example["effects"])


def test_the_scene_of_the_docs_rates_every_mode():
    scene = sw.load_scene(Path(sw.__file__).parents[1] / "docs" / "rated_pair.toml")
    assert set(REQUIRED) <= {name for name, _ in scene.effects.present()}

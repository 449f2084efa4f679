"""Tables of effects: present or absent, their ranges, what they need, and what each says about itself."""

import tomllib
from dataclasses import FrozenInstanceError, fields, is_dataclass
from importlib import resources
from typing import Any

import pytest

from semiwear.errors import SceneError
from semiwear.meshing.flank_deviations import DEVIATIONS
from semiwear.meshing.pairs import MESHES
from semiwear.scene import EFFECTS, Effects, EffectTable, Placement, Scene, load_scene, parse_scene, scene_from_dict
from semiwear.scene.effects import (
    FlankModification,
    Friction,
    HardnessLaw,
    LoadLaw,
    Misalignment,
    Modifications,
    RatingTable,
    WearLaws,
)
from semiwear.scene.kinds import KINDS
from semiwear.scene.schema import SCHEMAS
from semiwear.wear.laws import CONTACT_LAWS
from tests.scenes import problems_of
from tests.strategies.oil_and_case import FLANK_FRACTURE, MICROPITTING, SCUFFING
from tests.strategies.ratings import BENDING, PITTING
from tests.strategies.scenes import effect_tables

NAME = "face_gear_25x160"
TEXT = (resources.files("semiwear.scene") / "scenes" / f"{NAME}.toml").read_text(encoding="utf-8")
FACE_GEAR = SCHEMAS["face_gear"]
RULES, TABLES, DEFAULTS, REQUIRED = FACE_GEAR.rules, FACE_GEAR.tables, FACE_GEAR.defaults, FACE_GEAR.required
STAGES = {"geometry", "meshing", "compliance", "contact", "wear", "results"}
SPEED = "operation.pinion_speed_rpm"
# What a table cannot do without.
LEAST: dict[str, dict[str, Any]] = {
    "load_spectrum": {"torques_Nm": [800, 1600], "shares": [0.4, 0.6]},
    "pitch_error": {"pinion_um": [0, 5]},
    "pitting": PITTING,
    "bending": BENDING,
    "micropitting": MICROPITTING,
    "scuffing": SCUFFING,
    "flank_fracture": FLANK_FRACTURE,
}


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(NAME)


@pytest.fixture(scope="module")
def ready(scene: Scene) -> Scene:
    """The shipped scene with all that any effect may need."""
    further = {f"effects.{name}": {} for name in ("lubrication", "flash_temperature", "wear_law.lubrication")}
    return scene.replace({SPEED: 1500} | further)


@pytest.mark.parametrize("name", EFFECTS)
class TestEveryEffect:
    def test_says_what_it_is(self, name: str) -> None:
        table = EFFECTS[name]
        assert issubclass(table, EffectTable)
        assert is_dataclass(table)
        assert 0 < len(table.title) < 40
        assert table.acts_in in STAGES
        assert table.validity
        assert table.references
        assert all(reference for reference in table.references)

    def test_needs_are_fields_or_tables(self, name: str) -> None:
        table = EFFECTS[name]
        assert all(need in RULES or need in TABLES for need in table.needs)
        for (field, value), needs in table.needs_if.items():
            assert RULES[f"effects.{name}.{field}"].holds(value)
            assert all(need in RULES or need in TABLES for need in needs)

    def test_defaults_are_in_their_own_range(self, name: str) -> None:
        for entry in fields(EFFECTS[name]):
            key = f"effects.{name}.{entry.name}"
            default = DEFAULTS.get(key)
            if default is not None:
                assert RULES[key].apply(key, default) == (default, None)

    def test_is_written_even_with_nothing_but_defaults(self, ready: Scene, name: str) -> None:
        # A table of which nothing is written would be absent when read again.
        assert any(DEFAULTS.get(f"effects.{name}.{entry.name}") is not None for entry in fields(EFFECTS[name])) or (
            name in LEAST
        )
        with_it = ready.replace({f"effects.{name}": LEAST.get(name, {})})
        assert f"[effects.{name}]" in with_it.to_toml()
        assert parse_scene(with_it.to_toml()) == with_it

    def test_comes_and_goes(self, ready: Scene, name: str) -> None:
        key = f"effects.{name}"
        if name == "lubrication":
            ready = ready.replace({"effects.wear_law.lubrication": None})  # which needs it
        without = ready.replace({key: None}) if name not in ("lubrication", "flash_temperature") else ready
        with_it = without.replace({key: LEAST.get(name, {})})
        assert isinstance(with_it.effects.get(name), EFFECTS[name])
        assert name in dict(with_it.effects.present())
        gone = with_it.replace({key: None})
        assert gone.effects.get(name) is None
        assert gone.replace({key: None}) == gone
        assert key not in gone.to_toml()

    def test_instances_are_frozen_and_hashable(self, ready: Scene, name: str) -> None:
        table = ready.replace({f"effects.{name}": LEAST.get(name, {})}).effects.get(name)
        assert hash(table) == hash(table)
        with pytest.raises(FrozenInstanceError):
            setattr(table, fields(EFFECTS[name])[0].name, 1)

    def test_wrong_kind_of_table(self, ready: Scene, name: str) -> None:
        for value in (True, 5, "on", [{}]):
            assert list(problems_of(ready.replace, {f"effects.{name}": value})) == [f"effects.{name}"]

    def test_misspelled(self, scene: Scene, name: str) -> None:
        key = f"effects.{name}_"
        problem = problems_of(scene.replace, {key: LEAST.get(name, {})})[key]
        assert f"did you mean {name.rpartition('.')[2]}?" in problem.fix

    def test_has_a_strategy(self, name: str) -> None:
        assert set(effect_tables()) == set(EFFECTS)


class TestPresence:
    def test_none_by_default(self, scene: Scene) -> None:
        assert scene.effects == Effects()
        assert list(scene.effects.present()) == []
        assert all(scene.effects.get(name) is None for name in EFFECTS)

    def test_empty_table_in_a_file(self) -> None:
        read = parse_scene(TEXT + "\n[effects.friction]\n[effects.wear_law.hardness]\n[effects.modification.gear]\n")
        assert read.effects == Effects(
            friction=Friction(),
            wear_law=WearLaws(hardness=HardnessLaw()),
            modification=Modifications(gear=FlankModification()),
        )
        assert [name for name, _ in read.effects.present()] == ["modification.gear", "friction", "wear_law.hardness"]
        assert parse_scene(read.to_toml()) == read

    def test_empty_effects_are_none(self, scene: Scene) -> None:
        assert parse_scene(TEXT + "\n[effects]\n") == scene
        assert scene.replace({"effects": {}}) == scene

    def test_field_brings_its_table(self, scene: Scene) -> None:
        changed = scene.replace({"effects.friction.coefficient": 0.08, "effects.wear_law.load.exponent": 1})
        assert changed.effects == Effects(
            friction=Friction(coefficient=0.08), wear_law=WearLaws(load=LoadLaw(exponent=1))
        )
        assert changed.replace({"effects.friction.coefficient": None}).effects.friction == Friction()
        assert changed.replace({"effects": None}) == scene
        assert changed.replace({"effects": None}).sha256 == scene.sha256

    def test_none_brings_no_table(self, scene: Scene) -> None:
        assert scene.replace({"effects.friction.coefficient": None, "effects.wear_law.load": None}) == scene

    def test_last_wear_law_takes_its_container_along(self, scene: Scene) -> None:
        one = scene.replace({"effects.wear_law.load": {}})
        assert one.replace({"effects.wear_law.load": None}) == scene

    @pytest.mark.parametrize("name", ["wear_law", "modification"])
    def test_container_without_effects_is_no_effect(self, scene: Scene, name: str) -> None:
        for empty in ({}, {next(key for key in EFFECTS if key.startswith(name)).rpartition(".")[2]: None}):
            problems = problems_of(scene.replace, {f"effects.{name}": empty})
            assert list(problems) == [f"effects.{name}"]
            assert f"[effects.{name}." in problems[f"effects.{name}"].fix

    def test_a_value_switches_nothing(self, scene: Scene) -> None:
        assert scene.replace({SPEED: 1500}).effects == Effects()

    def test_get_knows_its_names(self, scene: Scene) -> None:
        with pytest.raises(KeyError, match="misalignment"):
            scene.effects.get("hub")

    def test_nested_dict_round_trip(self, ready: Scene) -> None:
        full = ready.replace({f"effects.{name}": LEAST.get(name, {}) for name in EFFECTS})
        assert len(list(full.effects.present())) == len(EFFECTS)
        assert scene_from_dict(full.to_dict()) == full
        assert tomllib.loads(full.to_toml()) == full.to_dict()
        assert full.to_dict()["effects"]["load_spectrum"]["shares"] == [0.4, 0.6]
        assert full.effects.load_spectrum is not None
        assert full.effects.load_spectrum.shares == (0.4, 0.6)

    def test_placement_of_a_misalignment(self) -> None:
        values = {entry.name: 0.1 * (k + 1) for k, entry in enumerate(fields(Misalignment))}
        assert Misalignment(**values).placement == Placement(**values)
        assert Misalignment().placement.is_aligned


# a screening adds no failure mode: it needs data of the materials
@pytest.mark.parametrize("name", [name for name, table in EFFECTS.items() if not issubclass(table, RatingTable)])
def test_screening_table_is_valid_and_does_something(ready: Scene, name: str) -> None:
    table = EFFECTS[name].screening_table(ready)
    screened = ready.replace({f"effects.{name}": table})
    assert screened.effects.get(name) is not None
    assert parse_scene(screened.to_toml()) == screened
    if name in ("misalignment", "modification.pinion", "modification.gear"):
        assert screened.effects.get(name) != EFFECTS[name]()


class TestScreening:
    def test_load_spectrum_follows_the_torque(self, scene: Scene) -> None:
        half = scene.replace({"operation.pinion_torque_Nm": 800})
        table = EFFECTS["load_spectrum"].screening_table(half)
        assert table == {"torques_Nm": [400.0, 800.0, 1000.0], "shares": [0.3, 0.5, 0.2]}

    def test_run_life_is_of_a_worn_body(self, scene: Scene) -> None:
        change = {"wear.worn_bodies": ["pinion"], "wear.until.meshes": 1e9, "wear.control_point": None}
        assert EFFECTS["run_life"].screening_table(scene.replace(change)) == {"body": "pinion"}
        assert EFFECTS["run_life"].screening_table(scene.replace({"wear": None})) == {}


class TestNeeds:
    @pytest.mark.parametrize(
        ("table", "needs"),
        [
            ("lubrication", {SPEED}),
            ("flash_temperature", {SPEED}),
            ("wear_law.lubrication", {"effects.lubrication", SPEED}),
            ("running_in", {"effects.wear_law.lubrication", "effects.lubrication", SPEED}),
            ("wear_law.temperature", {"effects.flash_temperature", SPEED}),
        ],
    )
    def test_missing_ones_are_all_named(self, scene: Scene, table: str, needs: set[str]) -> None:
        problems = problems_of(scene.replace, {f"effects.{table}": {}})
        assert set(problems) == needs
        assert all(problem.value is None for problem in problems.values())
        assert any(f"needed by [effects.{table}]: add it" in problem.fix for problem in problems.values())

    def test_message(self, scene: Scene) -> None:
        with pytest.raises(SceneError) as caught:
            scene.replace({"effects.lubrication": {}, "effects.flash_temperature": {}})
        assert (
            "operation.pinion_speed_rpm: missing; allowed: greater than 0 rev/min "
            "-> needed by [effects.flash_temperature] and [effects.lubrication]: add it"
        ) in str(caught.value)

    @pytest.mark.parametrize("table", [name for name, table in EFFECTS.items() if "wear" in table.needs])
    def test_wear(self, ready: Scene, table: str) -> None:
        problems = problems_of(ready.replace, {"wear": None, f"effects.{table}": LEAST.get(table, {})})
        assert set(problems) == {"wear"}
        assert f"[effects.{table}]" in problems["wear"].fix

    def test_only_one_law_of_friction_needs_speed(self, scene: Scene) -> None:
        assert scene.replace({"effects.friction.law": "constant"}).effects.friction == Friction()
        assert set(problems_of(scene.replace, {"effects.friction.law": "iso_14179"})) == {SPEED}
        assert scene.replace({"effects.friction.law": "iso_14179", SPEED: 1500})
        assert set(problems_of(scene.replace, {"effects.friction.law": "iso"})) == {"effects.friction.law"}

    def test_wrong_value_is_not_called_missing(self, scene: Scene) -> None:
        assert problems_of(scene.replace, {SPEED: -5, "effects.lubrication": {}})[SPEED].value == -5

    def test_misplaced_value_is_not_called_missing(self, scene: Scene) -> None:
        start = scene.to_dict()
        start["effects"] = {"lubrication": {"pinion_speed_rpm": 1500}}
        problems = problems_of(scene_from_dict, start)
        assert list(problems) == ["effects.lubrication.pinion_speed_rpm"]
        assert "did you mean operation.pinion_speed_rpm?" in problems["effects.lubrication.pinion_speed_rpm"].fix

    @pytest.mark.parametrize("name", LEAST)
    def test_required_fields(self, ready: Scene, name: str) -> None:
        problems = problems_of(ready.replace, {f"effects.{name}": {}})
        needed = {need for needs in EFFECTS[name].needs_if.values() for need in needs}
        assert set(problems) == {f"effects.{name}.{field}" for field in LEAST[name]} <= REQUIRED | needed
        assert all(f"needed by [effects.{name}]: add it" in problem.fix for problem in problems.values())


OUT_OF_RANGE = [
    ("misalignment.offset_mm", 5.1),
    ("misalignment.shaft_angle_error_mrad", -51),
    ("modification.pinion.tip_relief_um", -1),
    ("modification.pinion.tip_relief_length_mm", 0),
    ("modification.gear.crowning_um", -5),
    ("modification.gear.bias_um", 1001),
    ("modification.gear.relief_shape", "quadratic"),
    ("modification.gear.file", "flank.xlsx"),
    ("modification.gear.file", ""),
    ("free_edges.strength", 1.01),
    ("friction.law", "coulomb"),
    ("friction.coefficient", -0.05),
    ("friction.viscosity_mPas", 0),
    ("flash_temperature.model", "jaeger"),
    ("flash_temperature.bulk_temperature_C", 4000),
    ("flash_temperature.specific_heat_J_per_kgK", 0),
    ("lubrication.model", "grubin"),
    ("lubrication.roughness_um", 0),
    ("lubrication.pressure_viscosity_per_GPa", 2e-8),
    ("lubrication.pressure_viscosity_per_GPa", 20e9),
    ("wear_law.hardness.surface_hardness_HV", 10),
    ("wear_law.hardness.case_depth_um", 0),
    ("wear_law.hardness.transition_um", -1),
    ("wear_law.hardness.transition_um", 60.1),
    ("wear_law.hardness.pitch_band_mm", 0),
    ("wear_law.lubrication.full_film_lambda", 0.5),
    ("wear_law.lubrication.strength", -0.1),
    ("wear_law.temperature.activation_energy_kJ_per_mol", -1),
    ("running_in.acts_on", "friction"),
    ("running_in.strength", 1.0),
    ("running_in.depth_um", 0),
    ("wear_law.load.exponent", 4.1),
    ("wear_law.load.exponent", -2.1),
    ("wear_law.load.reference_pressure_MPa", 0),
    ("load_spectrum.torques_Nm", []),
    ("load_spectrum.shares", [0.4, 0.0]),
    ("load_spectrum.shares", [0.4, 0.5]),
    ("load_spectrum.shares", [1.0]),
    ("pitch_error.pinion_um", [5]),
    ("pitch_error.pinion_um", list(range(26))),
    ("shaft_compliance.offset_um_per_kN", -1),
    ("run_life.depth_limit_um", 0),
    ("run_life.body", "wheel"),
]
WRONG_TYPE = [
    ("misalignment.offset_mm", "0.1"),
    ("misalignment.offset_mm", float("nan")),
    ("modification.pinion.file", 5),
    ("friction.law", 1),
    ("friction.coefficient", True),
    ("free_edges.strength", [1.0]),
    ("load_spectrum.torques_Nm", 1600),
    ("load_spectrum.shares", [0.4, "0.6"]),
    ("pitch_error.pinion_um", [0, float("inf")]),
]
# what else is refused, and words of the way out
WAYS_OUT = [
    ("friction.law", "constnat", 'did you mean "constant"?'),
    ("friction.coefficient", 5, "not in per cent"),
    ("misalignment.offset_mm", 50, "um divided by 1000"),
    ("load_spectrum.shares", [40, 60], "not in per cent"),
    ("load_spectrum.shares", [0.4, 0.4], "they sum to 0.8: give [0.5, 0.5]"),
    ("load_spectrum.shares", [0.3, 0.3, 0.4], "there are 3"),
    ("load_spectrum.torques_Nm", [800, -1], "entry 2 is -1"),
    ("wear_law.lubrication.full_film_lambda", 0.2, "swap them: 0.2 and 0.5"),
    ("run_life.body", "pinion", 'add "pinion" to wear.worn_bodies'),
    ("pitch_error.pinion_um", [0, 5000], "entry 2 is 5000"),
]


class TestFields:
    @pytest.mark.parametrize(
        ("key", "value", "fix"), [*((key, value, "") for key, value in OUT_OF_RANGE + WRONG_TYPE), *WAYS_OUT]
    )
    def test_refused_alone_with_range_and_fix(self, ready: Scene, key: str, value: Any, fix: str) -> None:
        name, _, field = key.rpartition(".")
        table = LEAST.get(name, {}) | {field: value}
        problems = problems_of(ready.replace, {f"effects.{name}": table})
        assert list(problems) == [f"effects.{key}"]
        assert problems[f"effects.{key}"].value is not None
        assert fix in problems[f"effects.{key}"].fix

    @pytest.mark.parametrize(
        ("key", "value"),
        [
            ("misalignment.offset_mm", -5),
            ("misalignment.pinion_slope_mrad", 50),
            ("modification.gear.file", "measured/flank.CSV"),
            ("modification.gear.file", "flank.nc"),
            ("modification.pinion.lead_slope_um", -20),
            ("free_edges.strength", 0),
            ("friction.coefficient", 0),
            ("friction.coefficient", 1),
            ("wear_law.hardness.transition_um", 60),
            ("wear_law.temperature.activation_energy_kJ_per_mol", 0),
            ("wear_law.load.exponent", -2),
            ("wear_law.load.exponent", 4),
            ("pitch_error.pinion_um", list(range(25))),
            ("shaft_compliance.offset_um_per_kN", 0),
        ],
    )
    def test_limits_of_the_range_are_accepted(self, ready: Scene, key: str, value: Any) -> None:
        changed = ready.replace({f"effects.{key}": value})
        assert parse_scene(changed.to_toml()) == changed

    @pytest.mark.parametrize("shares", [[1, 1, 1], [0.1, 0.2, 0.3], [0.9, 0.05, 0.04], [1e-7, 0.5, 0.6]])
    def test_suggested_shares_are_accepted(self, scene: Scene, shares: list[float]) -> None:
        table = {"torques_Nm": [1, 2, 3], "shares": shares}
        fix = problems_of(scene.replace, {"effects.load_spectrum": table})["effects.load_spectrum.shares"].fix
        suggested = [float(share) for share in fix.partition("give [")[2].rstrip("]").split(",")]
        assert scene.replace({"effects.load_spectrum": table | {"shares": suggested}})

    def test_shares_may_be_rounded(self, scene: Scene) -> None:
        table = {"torques_Nm": [1, 2, 3], "shares": [0.3333333, 0.3333333, 0.3333333]}
        assert scene.replace({"effects.load_spectrum": table})


class TestNames:
    def test_all_problems_at_once(self, scene: Scene) -> None:
        problems = problems_of(
            scene.replace,
            {
                "effects.frictoin": {},
                "effects.lubrication": {"viscosity_mPa": 10, "roughness_um": -1},
                "effects.load_spectrum": {"torques_Nm": [800], "shares": [0.5, 0.5]},
                "effects.run_life": "yes",
            },
        )
        assert set(problems) == {
            "effects.frictoin",
            "effects.lubrication.viscosity_mPa",
            "effects.lubrication.roughness_um",
            "effects.load_spectrum.shares",
            "effects.run_life",
            SPEED,
        }
        assert "did you mean viscosity_mPas?" in problems["effects.lubrication.viscosity_mPa"].fix

    @pytest.mark.parametrize(
        ("key", "meant"),
        [
            ("friction", "did you mean effects.friction?"),
            ("efects", "did you mean effects?"),
            ("effects.hardness", "did you mean effects.wear_law.hardness?"),
            ("lubrication", "did you mean effects.lubrication or effects.wear_law.lubrication?"),
            ("effects.lubricaton", "did you mean lubrication?"),
            ("effects.wear_law.lubricaton", "did you mean lubrication?"),
            ("effects.modification.wheel", "remove it"),
        ],
    )
    def test_misspelled_or_misplaced_table(self, ready: Scene, key: str, meant: str) -> None:
        start = ready.to_dict()
        table = start
        *path, name = key.split(".")
        for step in path:
            table = table.setdefault(step, {})
        table[name] = {}
        problems = problems_of(scene_from_dict, start)
        assert {field: problem.fix for field, problem in problems.items()} == {key: meant}

    def test_effects_are_tables(self, scene: Scene) -> None:
        for value in (5, ["friction"], "friction"):
            problem = problems_of(scene.replace, {"effects": value})["effects"]
            assert "[effects.misalignment]" in problem.fix


def test_every_table_has_its_physics():
    """A table that is listed in a scene and nowhere else would do nothing."""
    laws = {name for name in EFFECTS if name.startswith("wear_law.")}
    assert laws == {*CONTACT_LAWS, "wear_law.hardness"}
    assert {name for name, kind in EFFECTS.items() if kind.acts_in == "geometry"} == set(DEVIATIONS)
    assert set(KINDS) == set(MESHES)
    assert all(pair.pitch_surfaces and pair.references for pair, _ in KINDS.values())

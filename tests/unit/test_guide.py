"""Scenes to start from, the list of fields, and the JSON schema: all from the declarations."""

import json
import tomllib
from pathlib import Path

import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.scene.guide import field_notes, fields_text, json_schema, new_scene
from semiwear.scene.schema import SCHEMAS

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("kind", SCHEMAS)
def test_a_new_scene_is_sound(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", kind]) == 0
    scene = sw.load_scene(tmp_path / f"my_{kind}.toml")
    assert scene.title.startswith("My ")
    assert scene.wear is not None
    assert sw.plan(scene) is not None
    assert main(["new", kind]) == 2  # nothing is overwritten


def test_flanks_in_another_folder(tmp_path: Path) -> None:
    assert main(["new", "flank_points", "-o", str(tmp_path / "mine.toml")]) == 0
    assert sw.load_scene(tmp_path / "mine.toml").gear_pair.pinion_file == str(tmp_path / "pinion.nc")


@pytest.mark.parametrize("kind", SCHEMAS)
def test_elastic_constants_shown_in_a_new_scene_may_be_uncommented(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", kind]) == 0
    path = tmp_path / f"my_{kind}.toml"
    text = path.read_text(encoding="utf-8")
    for name in ("youngs_modulus_MPa", "poissons_ratio"):
        assert text.count(f"# {name} = ") == 2
        text = text.replace(f"# {name} = ", f"{name} = ")
    as_shown = sw.load_scene(path)
    path.write_text(text, encoding="utf-8")
    assert sw.load_scene(path).material == as_shown.material


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_field_stands_in_a_new_scene(kind: str) -> None:
    text = new_scene(kind)
    for note in field_notes(kind):
        name = note.key.rpartition(".")[2]
        assert f"\n{name} = " in text or f"\n# {name} =" in text, note.key
    assert tomllib.loads(text)["gear_pair"]["type"] == kind


def test_the_list_of_fields_names_unit_default_and_range(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fields", "operation"]) == 0
    text = capsys.readouterr().out
    assert "operation.pinion_torque_Nm [N m]: required" in text
    assert 'operation.loaded_flank: "drive"' in text
    assert "greater than 0 N m" in text
    assert "effects.friction.coefficient" in fields_text("face_gear", "effects")
    with pytest.raises(sw.SceneError, match="did you mean operation"):
        fields_text("face_gear", "opration")
    with pytest.raises(sw.SceneError, match="did you mean cylindrical"):
        fields_text("cylindric")


def test_the_schema_knows_every_field_and_choice() -> None:
    properties = json_schema()["properties"]
    for kind in SCHEMAS:
        for note in field_notes(kind):
            here = properties
            *tables, name = note.key.split(".")
            for table in tables:
                here = here[table]["properties"]
            assert kind in here[name]["x-kinds"]
    assert properties["operation"]["properties"]["loaded_flank"]["enum"] == ["drive", "coast"]
    assert properties["numerics"]["properties"]["fidelity"]["enum"] == ["line", "patch"]
    assert properties["gear_pair"]["properties"]["type"]["enum"] == list(SCHEMAS)
    assert properties["gear_pair"]["properties"]["pinion_teeth"]["type"] == "integer"
    assert properties["wear"]["properties"]["coefficient_mm2_per_N"]["type"] == ["number", "object"]
    assert "free_edges" in properties["effects"]["properties"]


def test_the_schema_that_ships_is_that_of_the_declarations() -> None:
    stored = json.loads((ROOT / "docs" / "scene.schema.json").read_text(encoding="utf-8"))
    assert stored == json.loads(json.dumps(json_schema())), (
        "renew it: semiwear fields --json-schema > docs/scene.schema.json"
    )

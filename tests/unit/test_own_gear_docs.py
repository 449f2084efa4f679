"""The pages that lead from a drawing to a scene: their scenes are sound, and every field that they name exists."""

import re
import tomllib
from pathlib import Path

import pytest

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.scene import parse_scene
from semiwear.scene.schema import SCHEMAS

DOCS = Path(__file__).parents[2] / "docs"
OWN, MATERIALS = (DOCS / name for name in ("own_gear.md", "materials.md"))


def blocks(path):
    return re.findall(r"```toml\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("text", blocks(OWN), ids=["spur", "face gear"])
def test_its_scenes_are_sound_and_run_2000_hours(text):
    scene = parse_scene(text, check=geometric_problems)
    assert sw.check_geometry(scene).holds
    assert scene.wear.until.hours == 2000.0 and scene.effects.run_life.depth_limit_um == 50.0
    assert scene.wear.until.meshes == pytest.approx(
        60.0 * 2000.0 * 1500.0 * scene.gear_pair.pinion_teeth / scene.gear_pair.gear_teeth
    )


def test_its_named_data_are_those_of_a_scene():
    (text,) = blocks(MATERIALS)
    spur = sw.load_scene("spur_fzg_c")
    given = tomllib.loads(text)
    changes = {
        "material.pinion": given["material"]["pinion"],
        "material.gear": given["material"]["gear"],
        "wear.coefficient_mm2_per_N": None,
        "wear.worn_bodies": None,
        "wear.data": given["wear"]["data"],
        "operation.pinion_speed_rpm": 1000.0,
        "effects.lubrication": given["effects"]["lubrication"],
    }
    named = spur.replace(changes)
    assert named.material.gear.name == "POM" and named.wear.worn_bodies == ("gear",)
    assert named.effects.lubrication.viscosity_mPas > 0.0


def test_every_field_that_they_name_exists():
    known = {key.rpartition(".")[2] for schema in SCHEMAS.values() for key in schema.rules} | {
        "coefficient_mm2_per_N"
    }
    for path in (OWN, MATERIALS):
        named = re.findall(r"`([a-z_0-9A-Z]+_(?:mm|deg|rpm|um|Nm|teeth|shift|C|mm2_per_N))`", path.read_text("utf-8"))
        assert len(named) >= 1
        assert set(named) <= known, set(named) - known

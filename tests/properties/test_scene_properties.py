"""Scenes survive writing and reading, and no file content makes anything but a scene or a SceneError."""

import copy
import datetime
import re
import tomllib
from importlib import resources
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.scene import Placement, Scene, parse_scene, scene_from_dict
from semiwear.scene.schema import SCHEMAS
from tests.strategies import placements, scenes
from tests.strategies.scenes import SHIPPED, effects, named_changes

TEXT = (resources.files("semiwear.scene") / "scenes" / "face_gear_25x160.toml").read_text(encoding="utf-8")
UNCHECKED = parse_scene(TEXT)
RULES, TABLES = SCHEMAS["face_gear"].rules, SCHEMAS["face_gear"].tables
NAMES = sorted({key.rpartition(".")[2] for key in [*RULES, *TABLES] if key} | {"modul_mm", "", "a.b"})

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from([0, -1, 10**400, 1e308, 5e-324, 2.0, 0.5, 25.0, 508.0]),
)
values = st.recursive(
    st.one_of(
        numbers,
        st.booleans(),
        st.text(st.characters(), max_size=8),
        st.sampled_from(["auto", "line", "patch", "gear", "pinion", "prism", "\ud800"]),
        st.just(datetime.date(2024, 1, 1)),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(NAMES), inner, max_size=4)),
    max_leaves=6,
)


@st.composite
def mutated_scenes(draw: st.DrawFn) -> dict[str, Any]:
    """The shipped scene's tables, and effects, with some entries changed, removed, added or renamed, at any depth."""
    data = copy.deepcopy(tomllib.loads(TEXT))
    if draw(st.booleans()):
        data = SHIPPED.replace(draw(effects())).to_dict()
    for _ in range(draw(st.integers(1, 5))):
        table = data
        while inner := [value for value in table.values() if isinstance(value, dict)]:
            if draw(st.booleans()):
                break
            table = draw(st.sampled_from(inner))
        present = st.sampled_from(sorted(table)) if table else st.sampled_from(NAMES)
        action = draw(st.sampled_from(["change", "scale", "remove", "add", "rename"]))
        name = draw(present)
        if action == "change":
            table[name] = draw(values)
        elif action == "scale" and isinstance(table.get(name), int | float):
            table[name] *= draw(st.sampled_from([2, 0.5, -1, 0, 1.01]))
        elif action == "remove":
            table.pop(name, None)
        elif action == "add":
            table[draw(st.one_of(st.sampled_from(NAMES), st.text(max_size=6)))] = draw(values)
        elif action == "rename" and name in table:
            table[draw(st.sampled_from([name[:-1], name.upper(), name + "_", *NAMES]))] = table.pop(name)
    return data


@given(scenes())
def test_writing_and_reading_gives_the_same_scene(scene: Scene) -> None:
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert hash(again) == hash(scene)
    assert again.sha256 == scene.sha256
    assert scene_from_dict(scene.to_dict()) == scene
    assert scene.replace({}) == scene


@given(st.data(), scenes())
def test_effects_survive_writing_and_reading(data: st.DataObject, scene: Scene) -> None:
    changes = data.draw(effects(scene))
    changed = scene.replace(changes)
    again = parse_scene(changed.to_toml())
    assert again == changed
    assert hash(again) == hash(changed)
    assert again.to_toml() == changed.to_toml()
    assert scene_from_dict(changed.to_dict()) == changed
    assert {f"effects.{name}" for name, _ in again.effects.present()} == {
        key for key in changes if key.startswith("effects.")
    }
    bare = changed.replace({"effects": None, "operation.pinion_speed_rpm": scene.operation.pinion_speed_rpm})
    assert bare == scene
    assert bare.sha256 == scene.sha256


@pytest.mark.slow
@given(mutated_scenes())
def test_any_content_gives_a_scene_or_every_problem(data: dict[str, Any]) -> None:
    before = repr(data)
    try:
        scene = scene_from_dict(data)
    except SceneError as error:
        assert error.problems
        assert all(problem.field and problem.allowed for problem in error.problems)
        assert str(error)
    else:
        assert parse_scene(scene.to_toml()) == scene
    assert repr(data) == before


@given(st.dictionaries(st.one_of(st.sampled_from([*RULES, *TABLES]), st.text(max_size=9)), values, max_size=4))
def test_any_change_gives_a_scene_or_every_problem(changes: dict[str, Any]) -> None:
    try:
        scene = UNCHECKED.replace(changes)
    except SceneError as error:
        assert str(error)
    else:
        assert parse_scene(scene.to_toml()) == scene


@given(
    start=st.integers(0, len(TEXT)),
    length=st.integers(0, 30),
    inserted=st.one_of(st.text(max_size=10), st.text('[]{}=".,#\n0159-+einf_x', max_size=10)),
)
def test_any_damage_to_the_text_gives_a_scene_or_every_problem(start: int, length: int, inserted: str) -> None:
    try:
        parse_scene(TEXT[:start] + inserted + TEXT[start + length :])
    except SceneError as error:
        assert str(error)


def _extremes() -> st.SearchStrategy[tuple[Scene, str, float]]:
    """A scene with its defaults left to follow, a field, and a number at or beyond the ends of its range."""
    pairs = []
    for name in ("face_gear_25x160", "spur_fzg_c"):
        scene = sw.load_scene(name)
        schema = SCHEMAS[scene.gear_pair.type]
        shifts = ("gear_pair.pinion_profile_shift", "gear_pair.gear_profile_shift")  # 16 teeth are undercut without
        left_out = [key for key in schema.fields_of("gear_pair") if key not in (*schema.required, *shifts)]
        scene = scene.replace(dict.fromkeys(left_out))
        pairs += [(scene, key, schema.rules[key].allowed) for key in schema.rules if key != "gear_pair.type"]

    def numbers_of(pair: tuple[Scene, str, str]) -> st.SearchStrategy[tuple[Scene, str, float]]:
        ends = [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", pair[2])]
        near = [end + step for end in ends for step in (0.0, 1e-9, -1e-9, 1.0, -1.0)]
        return st.sampled_from([*near, 0.0, 5e-324, 1e-300, 1e-9, 1e9, 1e300, -1.0]).map(lambda x: (*pair[:2], x))

    return st.sampled_from(pairs).flatmap(numbers_of)


@settings(max_examples=200)
@given(_extremes())
def test_numbers_at_and_beyond_the_ends_of_ranges_give_a_scene_or_limits_that_are_numbers(
    case: tuple[Scene, str, float],
) -> None:
    scene, key, value = case
    try:
        changed = scene.replace({key: value})
    except SceneError as error:
        assert all(problem.field and problem.allowed for problem in error.problems)
        assert not re.search(r"\b(nan|inf) (mm|um|deg)", str(error)), error
    else:
        assert parse_scene(changed.to_toml()).to_dict() == changed.to_dict()
        assert str(sw.plan(changed))


@given(placements())
def test_placements_are_values(placement: Placement) -> None:
    assert placement == copy.copy(placement)
    assert placement.is_aligned == (placement == Placement())


@given(named_changes())
def test_scenes_with_named_data_and_hours_come_back_from_their_text(changes):
    scene = SHIPPED.replace(changes)
    assert parse_scene(scene.to_toml()) == scene
    assert scene.replace({}) == scene
    assert scene.wear.until.meshes == pytest.approx(
        60.0 * changes["wear.until.hours"] * changes["operation.pinion_speed_rpm"] * 25 / 160
    )
    # another name leaves nothing of the first one
    other = SHIPPED.replace(changes | {"material.gear": "PEEK"})
    assert scene.replace({"material.gear": "PEEK"}) == other

"""Every name in the glossary is one of the code."""

import importlib
import re
from pathlib import Path

import pytest

import semiwear as sw
from semiwear.results import COORDINATES, VARIABLES
from semiwear.scene import EFFECTS

TEXT = (Path(sw.__file__).parents[1] / "docs" / "glossary.md").read_text(encoding="utf-8")
ROWS = [line for line in TEXT.splitlines() if line.startswith("| ") and not line.startswith(("| term", "| ---"))]
NAMES = sorted({re.findall(r"`([^`]+)`", row.rsplit("|", 2)[1])[0] for row in ROWS})
SCENES = [sw.load_scene(name) for name in sw.shipped_scenes()]


def found_in_package(name: str) -> bool:
    module, _, last = name.rpartition(".")
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        return hasattr(importlib.import_module(module), last)
    return True


def found_in_scenes(name: str) -> bool:
    if name.startswith("effects."):
        return name.removeprefix("effects.") in EFFECTS
    table, field = name.rsplit(".", 1)
    for scene in SCENES:
        part = scene
        for step in table.split("."):
            part = getattr(part, step, None)
        if field in getattr(part, "__dataclass_fields__", {}):
            return True
    return False


@pytest.mark.parametrize("name", NAMES)
def test_a_name_of_the_glossary_is_one_of_the_code(name):
    if name.startswith("/"):
        group, variable = name[1:].split("/")
        assert (group, variable) in VARIABLES or (variable in COORDINATES and any(g == group for g, _ in VARIABLES))
    elif name.startswith("semiwear."):
        assert found_in_package(name)
    else:
        assert found_in_scenes(name)


def test_every_term_stands_once_and_has_a_name():
    terms = [row.split("|")[1].strip() for row in ROWS]
    assert len(terms) >= 60 and len(set(terms)) == len(terms)

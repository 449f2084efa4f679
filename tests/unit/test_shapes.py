"""Arrays have the shapes that docstrings give them, in runs of every kind of pair and of both fidelities."""

import importlib
import pkgutil
from dataclasses import dataclass

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.problem import Candidates
from semiwear.plan import kept_lines
from tests.scenes import TINY
from tests.shapes import documented, held, misfit

CHANGES = {
    "face gear": {},
    "both bodies": {"wear.worn_bodies": ["pinion", "gear"]},
    "patch": {"numerics.fidelity": "patch"},
    "marched": {"numerics.fidelity": "patch", "numerics.wear_mapping": "marched"},
    "effects": {
        "operation.pinion_speed_rpm": 1000.0,
        "effects.friction": {},
        "effects.lubrication": {},
        "effects.flash_temperature": {},
        "effects.free_edges": {},
        "effects.modification.gear.tip_relief_um": 10.0,
        "effects.wear_law.temperature": {},
    },
}

# made anew by every run: what tests before it have left in a cache is not looked at again
ALWAYS = {"Candidates", "ContactLines", "ContactProblem", "FlankGrid", "Footprints", "RollGrid", "TeethLoads"}


@dataclass
class Example:
    """A class.

    Attributes
    ----------
    x, y : (S,) arrays [mm]
    both : (S, 2) array, optional
    flat : (2 S,) array or None
    """

    x: np.ndarray
    y: np.ndarray
    both: np.ndarray | None = None
    flat: np.ndarray | None = None


def test_shapes_are_read_from_a_docstring():
    assert documented(Example) == {"x": ("S",), "y": ("S",), "both": ("S", "2"), "flat": ("2 S",)}


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ({"x": (3,), "y": (3,), "both": (3, 2), "flat": (6,)}, ""),
        ({"x": (3,), "y": (4,)}, "y has shape (4,), not (S) with S = 3"),
        ({"x": (3,), "both": (3, 3)}, "both has shape (3, 3), not (S, 2) with 2 = 2"),
        ({"x": (3, 1)}, "x has shape (3, 1), not (S)"),
        ({"x": (3,), "flat": (5,)}, "flat has an axis of 5, not 2 S = 2 3"),
    ],
)
def test_what_contradicts_is_named(sizes, said):
    assert misfit(documented(Example), {name: np.zeros(size) for name, size in sizes.items()}) == said


@pytest.fixture(scope="module")
def modules():
    names = [entry.name for entry in pkgutil.walk_packages(sw.__path__, "semiwear.")]
    return [importlib.import_module(name) for name in names if not name.endswith("__main__")]


@pytest.mark.parametrize("kind", CHANGES)
def test_arrays_have_the_shapes_that_are_documented(shipped, modules, kind):
    one_step = {"wear.until.control_depths_um": None, "wear.until.meshes": 1e8, "wear.control_point": None}
    scene = shipped.replace({**TINY, **one_step, "numerics.wear_steps": 1, **CHANGES[kind]})
    kept_lines._traced.cache_clear()
    with held(modules, Candidates) as seen:
        sw.simulate(scene)
    assert {owner.__qualname__ for owner in seen} >= ALWAYS


def test_arrays_of_a_cylindrical_pair_too(modules):
    kept_lines._traced.cache_clear()
    with held(modules, Candidates) as seen:
        sw.simulate(sw.load_scene("spur_fzg_c").replace({**TINY, "numerics.wear_steps": 1}))
    assert {owner.__qualname__ for owner in seen} >= ALWAYS

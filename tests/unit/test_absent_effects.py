"""Absent means absent: no class of an effect is constructed, no module of it loaded, unless its table is there."""

import importlib
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact import line_contact
from semiwear.contact.line_contact import LINE
from semiwear.plan import plan
from semiwear.plan.ratings import MODES
from semiwear.scene import EFFECTS
from tests.strategies.effect_scenes import PLAIN, SPEED
from tests.strategies.oil_and_case import FLANK_FRACTURE, MICROPITTING, SCUFFING
from tests.strategies.ratings import BENDING, PITTING

ROOT = Path(sw.__file__).parents[1]
RUBBING = {"semiwear.contact.friction", "semiwear.contact.conditions", "semiwear.contact.line_conditions"}
OBSERVED = RUBBING | {
    "semiwear.observers",
    "semiwear.contact.film_thickness",
    "semiwear.contact.flash_temperature",
}
LAWS = OBSERVED - {"semiwear.observers"} | {"semiwear.wear.laws", "semiwear.wear.contact_factor"}
MODIFICATION = {"semiwear.meshing.flank_deviations", "semiwear.meshing.flank_modification"}
RATED = RUBBING - {"semiwear.contact.friction"} | {
    f"semiwear.ratings.{name}"
    for name in ("by_cycles", "contact", "failure", "life_curve", "load_factors", "miner", "mode")
}

CALM = RATED - {f"semiwear.ratings.{name}" for name in ("by_cycles", "life_curve", "miner")}
HEATED = CALM | OBSERVED | {f"semiwear.ratings.{name}" for name in ("heated_contact", "oil", "overload")}

# Modules that a table loads, those of what it needs included.
MODULES = {
    "misalignment": set(),
    "modification.pinion": MODIFICATION,
    "modification.gear": MODIFICATION,
    "free_edges": {"semiwear.compliance.free_edges"},
    "friction": OBSERVED | {"semiwear.contact.frictional_contact"},
    "flash_temperature": OBSERVED,
    "lubrication": OBSERVED,
    "wear_law.hardness": LAWS - {"semiwear.wear.contact_factor", "semiwear.contact.line_conditions"},
    "wear_law.lubrication": LAWS | OBSERVED,
    "wear_law.temperature": LAWS | OBSERVED,
    "wear_law.load": LAWS,
    "running_in": LAWS | OBSERVED | {"semiwear.contact.running_in", "semiwear.contact.worn_depth"},
    "load_spectrum": set(),
    "pitch_error": set(),
    "shaft_compliance": {"semiwear.compliance.mounting"},
    "pitting": RATED | {"semiwear.ratings.pitting"},
    "bending": RATED | {"semiwear.ratings.bending"},
    "micropitting": HEATED
    | {f"semiwear.ratings.{name}" for name in ("load_stages", "micropitting", "specific_film")},
    "scuffing": HEATED | {"semiwear.ratings.scuffing"},
    "flank_fracture": CALM
    | {f"semiwear.ratings.{name}" for name in ("flank_fracture", "hardness", "overload")}
    | {"semiwear.contact.worn_depth"},
    "run_life": set(),
}
OPTIONAL = set().union(*MODULES.values()) | {"semiwear.meshing.deviation_grid"}
TABLES = {
    "modification.gear": {"effects.modification.gear.tip_relief_um": 10.0},
    "flash_temperature": SPEED | {"effects.flash_temperature": {}},
    "lubrication": SPEED | {"effects.lubrication": {}},
    "wear_law.lubrication": SPEED | {"effects.lubrication": {}, "effects.wear_law.lubrication": {}},
    "wear_law.temperature": SPEED | {"effects.flash_temperature": {}, "effects.wear_law.temperature": {}},
    "running_in": SPEED | {"effects.lubrication": {}, "effects.wear_law.lubrication": {}, "effects.running_in": {}},
    "load_spectrum": {"effects.load_spectrum": {"torques_Nm": [800.0, 1600.0], "shares": [0.5, 0.5]}},
    "pitch_error": {"effects.pitch_error.pinion_um": [0.0, 5.0]},
    "pitting": SPEED | {"effects.pitting": PITTING},
    "micropitting": SPEED | {"effects.flash_temperature": {}, "effects.micropitting": MICROPITTING},
    "scuffing": SPEED | {"effects.flash_temperature": {}, "effects.scuffing": SCUFFING},
    "flank_fracture": {"effects.flank_fracture": FLANK_FRACTURE},
    "bending": {"effects.bending": BENDING, "numerics.tooth_compliance": "prism", "numerics.harmonics": 3},
    "run_life": {"effects.run_life.depth_limit_um": 1.0},
}
TINY = PLAIN.replace({"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.tooth_compliance": "rigid"})


def table(name):
    return TABLES.get(name, {f"effects.{name}": {}})


def contact_calls(monkeypatch, scene):
    """Calls of the contact solver and of its kernel in a run."""
    calls = {"solve": 0, "kernel": 0}
    kernel = line_contact.share_torque

    def counted_solve(*args, **kwargs):
        calls["solve"] += 1
        return LINE.solve(*args, **kwargs)

    def counted_kernel(*args, **kwargs):
        calls["kernel"] += 1
        return kernel(*args, **kwargs)

    with monkeypatch.context() as patched:
        patched.setattr(importlib.import_module("semiwear.plan"), "LINE", replace(LINE, solve=counted_solve))
        patched.setattr(line_contact, "share_torque", counted_kernel)
        sw.simulate(scene)
    return calls


@pytest.mark.slow
def test_effects_that_only_tell_solve_nothing(monkeypatch):
    with monkeypatch.context() as patched:
        # what would free pressing tips is found from loads shared once more, of every result
        patched.setattr("semiwear.collect.relief_to_free", lambda *_: np.zeros(2))
        alone = contact_calls(monkeypatch, TINY)
    # the unworn state, then of each of two steps a prediction, the loads and the contact at its end; edges twice more
    assert 1 + 2 * 3 <= alone["solve"] <= 3 + 2 * 5
    plain = contact_calls(monkeypatch, TINY)
    for name in ("flash_temperature", "lubrication", "misalignment", *sorted(set(MODES) - {"bending"})):
        assert contact_calls(monkeypatch, TINY.replace(table(name))) == plain
    bent = table("bending")  # which rigid teeth have none of
    without = TINY.replace({name: value for name, value in bent.items() if name != "effects.bending"})
    assert contact_calls(monkeypatch, TINY.replace(bent)) == contact_calls(monkeypatch, without)
    assert contact_calls(monkeypatch, TINY.replace(table("friction")))["solve"] > plain["solve"]


def test_a_scene_without_effects_has_no_hooks():
    """Where effects would act there is nothing, not something that does nothing."""
    physics = plan(TINY)
    teeth = physics.loaded_teeth()
    stepper = physics.wear_stepper(teeth)
    assert teeth.fidelity is LINE
    assert teeth.problem.more == () and teeth.problem.cells is None
    assert teeth.modification is None and teeth.driving is None
    assert stepper.cases == () and stepper.factor is None and stepper.depth_factor is None
    assert stepper.mapping.grow is np.add and stepper.mapping.grow_driving is np.add
    assert physics.observers(teeth) == ()


_LOADED = """
import json, sys
import semiwear as sw
from semiwear.scene import parse_scene

optional = set(sys.argv[1:])
found = []
for text in json.load(sys.stdin):
    sw.simulate(parse_scene(text))
    sw.loaded_contact(parse_scene(text))
    loaded = optional & set(sys.modules)
    found.append(sorted(loaded))
    # the next run starts without them
    for name in loaded:
        del sys.modules[name]
        package, _, leaf = name.rpartition(".")
        delattr(sys.modules[package], leaf)
print(json.dumps(found))
"""


def loaded_modules(*scenes):
    """Which modules of effects a new process has loaded after each of several runs."""
    done = subprocess.run(
        [sys.executable, "-c", _LOADED, *sorted(OPTIONAL)],
        input=json.dumps([scene.to_toml() for scene in scenes]),
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [set(entry) for entry in json.loads(done.stdout)]


def test_every_effect_says_what_it_may_load():
    assert set(MODULES) == set(EFFECTS)


@pytest.mark.slow
def test_no_module_of_an_absent_effect_is_loaded():
    """None without effects, and with one effect its own modules alone."""
    plain, *each = loaded_modules(TINY, *(TINY.replace(table(name)) for name in EFFECTS))
    assert plain == set()
    assert dict(zip(EFFECTS, each, strict=True)) == MODULES

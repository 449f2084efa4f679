"""Automatic wear steps follow the wear of whichever body wears."""

from __future__ import annotations

import pytest

import semiwear as sw
from semiwear.plan import plan
from semiwear.wear.step_count import LEAST_STEPS, MOST_STEPS, steps_for_depth
from tests.scenes import TINY, Heard


def worn(**changes):
    progress = Heard()
    scene = sw.load_scene("spur_fzg_c").replace(
        TINY | {"numerics.face_slices": 7, "numerics.profile_points": 41, "wear.until.meshes": 5e8} | changes
    )
    return sw.simulate(scene, progress=progress), progress.steps


@pytest.fixture(scope="module")
def runs():
    return {bodies: worn(**{"wear.worn_bodies": list(bodies)}) for bodies in (("pinion",), ("pinion", "gear"))}


def deepest(tree):
    return [float(depth) for depth in tree["flank"].wear_depth[-1].max(("profile", "face"))]


@pytest.mark.slow
@pytest.mark.parametrize("bodies", [("pinion",), ("pinion", "gear")])
def test_steps_are_counted_by_the_deepest_wear_of_either_body(runs, bodies):
    tree, heard = runs[bodies]
    pitch = plan(sw.load_scene("spur_fzg_c")).flank_pair().base_pitch
    taken = tree.sizes["wear_step"] - 1 if "wear_step" in tree.sizes else tree["history"].sizes["wear_step"] - 1
    assert LEAST_STEPS < taken == heard[-1][1]
    # a single step, which is what counts them, is some per cent too shallow
    asked = steps_for_depth(1e-3 * max(deepest(tree)), pitch)
    assert asked - 1 <= taken <= asked


def test_progress_tells_the_depth_of_every_worn_body(runs):
    pinion, gear = deepest(runs["pinion", "gear"][0])
    assert runs["pinion", "gear"][1][-1][2] == f"5e+08 meshes, pinion {pinion:.3g} um, gear {gear:.3g} um at most"
    pinion = deepest(runs["pinion",][0])[0]
    assert runs["pinion",][1][-1][2] == f"5e+08 meshes, {pinion:.3g} um at most"


def test_few_and_many_steps_are_bounded():
    assert steps_for_depth(0.0, 10.0) == LEAST_STEPS
    assert steps_for_depth(1.0, 10.0) == MOST_STEPS
    assert steps_for_depth(0.02, 10.0) == steps_for_depth(0.2, 100.0)

"""What runs share: contact lines, speeds and compliance of equal geometry, never a result's bits."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.compliance.cubics import cubic_weights
from semiwear.compliance.local_weights import LocalWeights, between_points, seen_by_points
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.removed import Removed
from semiwear.plan import effects, kept_lines, plan, teeth
from semiwear.wear.followed_gap import FollowedGap
from semiwear.wear.swept_line import wear_of_both_flanks, worn_sweep

SMALL = {"numerics.face_slices": 15, "numerics.roll_positions": 8, "numerics.harmonics": 3}


def forget() -> None:
    """As in a new process."""
    for kept in (kept_lines._traced, kept_lines._known_lines, effects._speeds):
        kept.cache_clear()
    for kept in (teeth._prisms_on_lines, teeth._known_compliance, teeth.toothed, teeth.prisms):
        kept.cache_clear()


def loaded(scene: sw.Scene) -> xr.DataTree:
    """Loads of a mesh cycle."""
    return sw.loaded_contact(scene)


def same(one: xr.DataTree, other: xr.DataTree) -> bool:
    """Whether two results agree to the last bit."""
    groups = ("engagement", "mesh_cycle")
    return all(one[group].to_dataset().identical(other[group].to_dataset()) for group in groups)


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    """A face gear on few slices."""
    return sw.load_scene("face_gear_25x160").replace(SMALL)


@pytest.fixture(scope="module")
def alone(scene: sw.Scene) -> xr.DataTree:
    """As in a new process."""
    forget()
    return loaded(scene)


@pytest.mark.parametrize(
    "before",
    [
        {"operation.pinion_torque_Nm": 2000.0},
        {"operation.pinion_torque_Nm": 50.0},
        {"effects.misalignment.offset_mm": 0.1},
        {"gear_pair.gear_tip_edge_radius_mm": 0.3},
        {"material.pinion.youngs_modulus_MPa": 110e3},
    ],
)
def test_a_run_is_the_same_whatever_ran_before(scene: sw.Scene, alone: xr.DataTree, before: dict[str, float]) -> None:
    """Of other torques, which ask for other slices, and of other geometry and material."""
    forget()
    loaded(scene.replace(before))
    assert same(loaded(scene), alone)


def test_lines_of_equal_geometry_are_traced_once(scene: sw.Scene) -> None:
    """Under any load and with any wear law; anew where a flank is placed elsewhere."""
    forget()
    one = plan(scene).loaded_teeth()
    for other in ({"operation.pinion_torque_Nm": 500.0}, {"wear.coefficient_mm2_per_N": 1e-15}):
        again = plan(scene.replace(other)).loaded_teeth()
        if again.rolls.pairs == one.rolls.pairs:
            assert again.fine is one.fine and again.problem.teeth is one.problem.teeth
    placed = plan(scene.replace({"effects.misalignment.offset_mm": 0.1})).loaded_teeth()
    assert placed.fine is not one.fine and placed.problem.teeth is not one.problem.teeth


@pytest.mark.parametrize("changes", [{}, {"gear_pair.helix_angle_deg": 15.0, "gear_pair.centre_distance_mm": None}])
def test_positions_between_others_are_the_same_in_any_company(changes: dict[str, float | None]) -> None:
    """As teeth of their own, and after other phases of other flanks have been solved."""
    scene = sw.load_scene("spur_fzg_c").replace(SMALL | changes)
    phase, tip_relief = np.array([0.1, 0.45, 0.7]), {"effects.modification.pinion.tip_relief_um": 25.0}

    def between(asked: sw.Scene, phase: np.ndarray) -> LoadedTeeth:
        physics = plan(asked)
        return physics.teeth_between(physics.loaded_teeth(), phase)

    forget()
    whole = plan(scene).loaded_teeth()
    alone = plan(scene).loaded_teeth(None, whole.rolls.start + phase)
    expected = alone.load(np.zeros(alone.grid.profile.shape))
    for other in ([0.2, 0.45], [0.1, 0.3, 0.9]):
        asked = between(scene.replace(tip_relief), np.array(other))
        asked.load(np.zeros(asked.grid.profile.shape))
    found = between(scene, phase)
    state = found.load(np.zeros(found.grid.profile.shape))
    assert found.zero == alone.zero == whole.zero
    np.testing.assert_array_equal(found.lines.separation, alone.lines.separation)
    np.testing.assert_array_equal(state.loads.force, expected.loads.force)
    np.testing.assert_array_equal(state.loads.rotation, expected.loads.rotation)


def test_compliance_between_points_by_few_neighbours() -> None:
    """As the whole sums over heights, sections, harmonics and splines, values and slopes, also at the ends."""
    random = np.random.default_rng(3)
    heights, sections, splines, harmonics, points = 7, 5, 6, 4, 11
    nodes = [np.linspace(0.0, 1.0, count) for count in (heights, sections, splines)]
    places = np.concatenate([[0.0, 1.0], random.uniform(size=points - 2)])
    (height, slope), (section, _), (spline, _) = (cubic_weights(places, own) for own in nodes)
    local = [LocalWeights.of(*weights) for weights in ((height, slope), (section,), (spline,))]
    cosine = random.normal(size=(points, harmonics))

    table = random.normal(size=(sections, heights, harmonics * heights))
    whole = [np.einsum("pb,ph,bhc->pc", section, w, table) * np.repeat(cosine, heights, 1) for w in (height, slope)]
    np.testing.assert_allclose(seen_by_points(table, local[0], local[1], cosine), np.concatenate(whole), atol=1e-12)

    table = random.normal(size=(heights * splines, heights * splines))
    load = (height[:, :, None] * spline[:, None]).reshape(points, -1)
    moved = (slope[:, :, None] * spline[:, None]).reshape(points, -1)
    observers, loads = np.arange(points), np.array([0, 3, 4, points - 1])
    whole = [own @ (load[loads] @ table).T for own in (load, moved)]
    found = between_points(table, splines, local[0], local[2], observers, loads)
    np.testing.assert_allclose(found, np.concatenate(whole), atol=1e-12)


def worn_teeth(scene: sw.Scene, deeper: float = 1.0) -> tuple[LoadedTeeth, np.ndarray, np.ndarray]:
    """Teeth of which both flanks wear, with waves, a groove and a bare stretch on them [mm]."""
    loaded_teeth = plan(scene).loaded_teeth()
    assert loaded_teeth.driving is not None
    random = np.random.default_rng(5)
    depths = []
    for grid in (loaded_teeth.grid, loaded_teeth.driving.grid):
        along = np.arange(grid.profile.shape[1])
        depth = deeper * (4e-3 + 4e-3 * np.sin(along / 3.0)) + 1e-3 * random.uniform(size=grid.profile.shape)
        depth[:, along > 0.7 * along.size] = 0.0
        depth[:, along < 4] += 0.02 * deeper
        depths.append(depth)
    return loaded_teeth, depths[0], depths[1]


_READ_BY_NOBODY = -1.0  # mm: as good as pressed


def inside(removed: Removed) -> np.ndarray:
    """Nodes within the windows, (roll, face, profile)."""
    assert removed.windows is not None
    node = np.arange(removed.depth.shape[-1])
    return np.asarray((removed.windows[..., :1] <= node) & (node < removed.windows[..., 1:]))


@pytest.mark.parametrize("name", ["face_gear_25x160", "spur_fzg_c"])
def test_what_lies_beyond_the_footprints_need_not_be_known(name: str) -> None:
    """Wear of both flanks from depths read in the windows of footprints and from depths read everywhere."""
    scene = sw.load_scene(name).replace(SMALL | {"wear.worn_bodies": ["pinion", "gear"]})
    loaded_teeth, driven, driving = worn_teeth(scene)
    state = loaded_teeth.load(driven, driving_wear=driving)
    line_load = loaded_teeth.on_fine_rolls(loaded_teeth.problem.line_load(state.loads))
    motion = worn_sweep(loaded_teeth, state)
    slices = np.arange(loaded_teeth.grid.face.size)
    windows = loaded_teeth.widest_windows(driven, driving, line_load > 0.0)
    less = 0.3 * driven, 0.6 * driving
    few = loaded_teeth.removed_at_nodes(driven, driving, slices, windows)
    before = loaded_teeth.removed_at_nodes(*less, slices, loaded_teeth.widest_windows(*less, line_load > 0.0))
    again = loaded_teeth.removed_at_nodes(driven, driving, slices, windows, before)
    within = inside(few)
    assert again.depth is before.depth and (again.depth[within] == few.depth[within]).all()
    few.depth[~within] = _READ_BY_NOBODY
    every = loaded_teeth.removed(driven, driving)
    flank = loaded_teeth.driving
    assert flank is not None
    alone = every.depth == flank.driven.from_grid(driven)
    assert alone[~flank.near].all() and not alone[flank.near].all()
    assert within.mean() < 0.7  # windows leave something out
    what = (motion, line_load, loaded_teeth.half_width, loaded_teeth.problem.modulus, slices)
    found, expected = (
        wear_of_both_flanks(loaded_teeth.fine, loaded_teeth.grid, flank, removed, *what) for removed in (few, every)
    )
    for one, other in zip(found, expected, strict=True):
        assert other.max() > 0.0
        np.testing.assert_allclose(one, other, atol=1e-12 * other.max())


@pytest.mark.parametrize("name", ["face_gear_25x160", "spur_fzg_c"])
@pytest.mark.parametrize("deeper", [1.0, 8.0])
def test_what_footprints_cannot_close_yet_need_not_be_known(name: str, deeper: float) -> None:
    """Wear of both flanks as they wear, from depths at the nodes that are followed and where footprints may lie."""
    scene = sw.load_scene(name).replace(SMALL | {"wear.worn_bodies": ["pinion", "gear"]})
    loaded_teeth, driven, driving = worn_teeth(scene, deeper)
    state = loaded_teeth.load(driven, driving_wear=driving)
    line_load = loaded_teeth.on_fine_rolls(loaded_teeth.problem.line_load(state.loads))
    motion = worn_sweep(loaded_teeth, state)
    slices = np.arange(loaded_teeth.grid.face.size)
    flank = loaded_teeth.driving
    assert flank is not None
    gap, random = FollowedGap(loaded_teeth, line_load, slices), np.random.default_rng(3)
    what = (motion, line_load, loaded_teeth.half_width, loaded_teeth.problem.modulus, slices)
    widths, memory = [], None
    for _ in range(12):
        few = gap.removed(driven, driving)
        assert memory is None or few.depth is memory
        memory = few.depth
        assert few.windows is not None
        windows = loaded_teeth.widest_windows(driven, driving, line_load > 0.0)
        wide = loaded_teeth.removed_at_nodes(driven, driving, slices, windows)
        few.depth[~inside(few)] = _READ_BY_NOBODY
        widths.append((np.diff(few.windows).sum(), np.diff(windows).sum()))
        found, expected = (
            wear_of_both_flanks(loaded_teeth.fine, loaded_teeth.grid, flank, removed, *what)
            for removed in (few, wide)
        )
        for one, other in zip(found, expected, strict=True):
            assert other.max() > 0.0
            np.testing.assert_allclose(one, other, atol=1e-12 * other.max())
        # in waves, by 0.3 at most of what they are followed for
        driven, driving = (
            depth + 0.15 * gap.margin * np.cos(2.0 * np.arange(depth.shape[1]) / 15.0 + 7.0 * random.uniform()) ** 2
            for depth in (driven, driving)
        )
    found_anew = sum(few != before for (few, _), (before, _) in pairwise(widths))
    assert 2 <= found_anew <= 3  # in twelve cycles of less than 0.3
    assert all(few < 0.9 * wide for few, wide in widths)

"""Tooth compliance from a file of influence data: sampled from the prisms, it has to give the prisms' answers."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from fem_reference import root_stress
from semiwear.compliance import tooth
from semiwear.compliance.influence import InfluenceData, InfluenceOnLines
from semiwear.compliance.tooth import BodyOnLines, LinePlaces
from semiwear.errors import SceneError
from semiwear.plan import plan

HEIGHTS, STATIONS, OFFSETS, FILLET = 13, 41, 3, 4


def sampled(body: BodyOnLines, ends) -> dict[str, np.ndarray]:
    """A body's prisms read on a grid; three teeth; stress of nothing but its own tooth, the deflection's shape."""
    faces = np.linspace(body.body.start, body.body.start + body.body.width, STATIONS)
    root, tip = (np.broadcast_to(end, faces.shape) for end in ends(faces))
    at = root + (tip - root) * np.linspace(0.0, 1.0, HEIGHTS)[:, None]
    face = np.broadcast_to(faces, at.shape)
    places = LinePlaces(at.reshape(1, -1), np.ones((1, at.size)), face.reshape(1, -1))
    here = BodyOnLines.of(body.body, places)
    points = np.arange(at.size)
    rolls, faces_2 = np.zeros(2 * at.size, dtype=int), np.tile(points, 2)
    matrix = np.zeros((2 * at.size, 2 * at.size))
    # pair 0 and pair 1: the observer's tooth is one ahead of the loaded one, or one behind
    here.add_compliance(rolls, faces_2, np.repeat([0, 1], at.size), matrix, np.zeros_like(matrix))
    n, ahead = at.size, body.body.ahead
    blocks = {0: matrix[:n, :n], ahead: matrix[n:, :n], -ahead: matrix[:n, n:]}
    shape = (HEIGHTS, STATIONS, HEIGHTS, STATIONS)
    deflection = np.stack([(0.5 * (blocks[k] + blocks[-k].T)).reshape(shape) for k in (-1, 0, 1)])
    return {"load_face": faces, "depth": here.depth.reshape(HEIGHTS, STATIONS), "deflection": deflection}


@pytest.fixture(scope="module")
def influence_file(small, tmp_path_factory):
    teeth = plan(small).loaded_teeth()
    pinion, gear = teeth.problem.bodies

    def of_pinion(faces):
        borders = teeth.pair.borders(faces, sharp=True)
        return borders.driving_root, borders.driving_tip

    def of_gear(faces):
        borders = teeth.pair.borders(faces, sharp=True)
        return borders.root, borders.tip

    parts = [sampled(pinion, of_pinion), sampled(gear, of_gear)]
    grid = ("observer_height", "observer_station", "height", "station")
    # beside a load that stands on the flank's end the first fillet point says nothing
    stress = np.ones((2, OFFSETS, FILLET, STATIONS, HEIGHTS, STATIONS))
    stress[:, :, 0] = 1e6
    data = xr.Dataset(
        {
            "load_face": (("body", "station"), np.stack([part["load_face"] for part in parts])),
            "depth": (("body", "height", "station"), np.stack([part["depth"] for part in parts])),
            "deflection": (("body", "tooth_offset", *grid), np.stack([part["deflection"] for part in parts])),
            "fillet_arc": (("body", "fillet_point"), np.tile(np.linspace(0.0, 8.0, FILLET), (2, 1))),
            "root_stress": (("body", "tooth_offset", "fillet_point", *grid[1:]), stress),
        }
    )
    path = tmp_path_factory.mktemp("influence") / "teeth.nc"
    data.to_netcdf(path)
    return path


def test_prisms_sampled_on_a_grid_give_the_prisms_answer(small, influence_file):
    by_prism = sw.loaded_contact(small)
    by_file = sw.loaded_contact(small.replace({"numerics.tooth_compliance": str(influence_file)}))
    # the deflection of a point load is as wide as the middle surface is deep, three grid cells: cubics are at 1 %
    share = by_file["engagement"].load_share - by_prism["engagement"].load_share
    assert float(np.abs(share).max()) < 0.01
    error = [tree["mesh_cycle"].transmission_error_loaded.values for tree in (by_file, by_prism)]
    np.testing.assert_allclose(error[0], error[1], rtol=0.02)
    rigid = sw.loaded_contact(small.replace({"numerics.tooth_compliance": "rigid"}))
    assert (
        np.abs(rigid["mesh_cycle"].transmission_error_loaded.values - error[1]).max() > 0.2 * np.abs(error[1]).max()
    )


def test_stress_at_the_end_of_the_flank_does_not_count(small, influence_file):
    tree = sw.loaded_contact(small.replace({"numerics.tooth_compliance": str(influence_file)}))
    # every load stresses every other fillet point of its own tooth and both neighbours by its own size
    assert float(tree["engagement"].root_stress.max()) < 1.01 * 1e3 * 1600.0 / (
        12.5 * 6.35 * np.cos(np.radians(25.0))
    )


def test_root_begins_at_one_place_for_the_core_and_for_finite_elements():
    assert tooth.ROOT_FROM == root_stress.ROOT_FROM


def test_root_stress_is_the_sum_over_teeth_and_loads():
    random = np.random.default_rng(3)
    heights, stations, fillet, per_cycle, rolls, faces = 4, 5, 3, 2, 8, 6
    stress = random.standard_normal((OFFSETS, fillet, stations, heights, stations))
    for ahead in (1, -1):
        body = InfluenceData(
            np.linspace(0.0, 1.0, heights), np.linspace(0.0, 8.0, stations), np.ones((heights, stations)),
            np.zeros((OFFSETS, heights, stations, heights, stations)), stress, ahead, 2e5, 0.3,
        )  # fmt: skip
        places = LinePlaces(
            random.uniform(0.0, 3.0, (rolls, faces)),
            np.ones((rolls, faces)),
            random.uniform(0.0, 8.0, (rolls, faces)),
        )
        on_lines = InfluenceOnLines.of(body, places, np.zeros((rolls, faces)), np.full((rolls, faces), 3.0))
        force = random.uniform(0.0, 1.0, (rolls, faces))
        found = on_lines.root_stress(force, per_cycle, stations=stations)
        for observer in range(rolls):
            total = np.zeros((fillet, stations))
            for loaded in range(observer % per_cycle, rolls, per_cycle):
                offset = ahead * (observer - loaded) // per_cycle
                if abs(offset) <= 1:
                    grid = (force[loaded, :, None] * on_lines.weights[loaded]).sum(axis=0).reshape(heights, stations)
                    total += np.einsum("akhs,hs->ak", stress[1 + offset], grid)
            assert found[observer] == pytest.approx(max(total.max(), 0.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data.drop_vars("deflection"), "deflection"),
        (lambda data: data.assign(depth=data.depth * np.nan), "finite"),
        (lambda data: data.assign(load_face=data.load_face + 5.0), "other gears"),
        (lambda data: data.isel(tooth_offset=slice(0, 2)), "odd number"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(small, influence_file, tmp_path, change, words):
    with xr.open_dataset(influence_file) as data:
        change(data.load()).to_netcdf(tmp_path / "wrong.nc")
    with pytest.raises(SceneError, match=r"numerics\.tooth_compliance") as caught:
        sw.loaded_contact(small.replace({"numerics.tooth_compliance": str(tmp_path / "wrong.nc")}))
    assert words in str(caught.value)


def test_a_file_that_is_not_there_is_named(small):
    with pytest.raises(SceneError, match=r"no such file.*tooth_influence"):
        sw.loaded_contact(small.replace({"numerics.tooth_compliance": "missing.nc"}))

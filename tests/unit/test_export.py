"""Exports are read by the other side: surfaces by PyVista, tables by pandas, and forces balance the torque."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import semiwear as sw
from semiwear.cli import main
from semiwear.errors import MissingExtraError
from semiwear.export.frames import TABLES, tables_of
from semiwear.export.nodes import flank_nodes
from semiwear.export.whole_teeth import contact_loads
from semiwear.meshing.own_flanks import own_flank
from tests.scenes import RIGID, SHIPPED, TINY, UNTIL_MESHES
from tests.strategies.results import synthetic_tree

pyvista = pytest.importorskip("pyvista", reason="extra view: surfaces are read by PyVista")

SPUR = sw.load_scene("spur_fzg_c").replace(TINY | {"numerics.wear_steps": 2})


@pytest.fixture(scope="module")
def tree():
    return sw.simulate(SPUR)


@pytest.fixture(scope="module")
def face_tree():
    until = {"wear.until.meshes": 1e8, "numerics.wear_steps": 1}
    return sw.simulate(SHIPPED.replace(RIGID | TINY | UNTIL_MESHES | until))


# ---- tables


def test_every_table_has_the_values_of_the_result(tree):
    assert set(tables_of(tree)) == set(TABLES) - {"life"}
    history = sw.to_frame(tree)
    assert list(history["meshes"]) == list(tree["history"].meshes.values)
    np.testing.assert_array_equal(
        history["root_stress_max[gear]"], tree["history"].root_stress_max.sel(body="gear").values
    )
    assert history.attrs["units"]["root_stress_max[gear]"] == "MPa"
    rows = sw.to_frame(tree, "engagement").set_index(["wear_step", "roll_position"])
    for step, roll in ((1, 5), (2, 11)):
        place = tree["engagement"].isel(wear_step=step, roll_position=roll)
        row = rows.loc[(step, float(place.roll_position))]
        assert row["load_share"] == float(place.load_share)
        assert row["root_stress[pinion]"] == float(place.root_stress.sel(body="pinion"))
    loads = sw.to_frame(tree, "line_loads")
    force = (loads.line_load * loads.line_length * loads.lever_arm).groupby(loads.wear_step).sum()
    positions = tree["mesh_cycle"].sizes["mesh_position"]
    np.testing.assert_allclose(force, 1e3 * SPUR.operation.pinion_torque_Nm * positions, rtol=1e-6)
    flank = sw.to_frame(tree, "flank")
    deepest = flank[(flank.wear_step == 2) & (flank.body == "gear")].wear_depth.max()
    assert deepest == float(tree["history"].wear_depth_max.isel(wear_step=2).sel(body="gear"))


def test_tables_are_read_by_pandas(tree, tmp_path):
    sw.export(tree, tmp_path / "a.csv", table="mesh_cycle")
    read, own = pd.read_csv(tmp_path / "a.csv"), sw.to_frame(tree, "mesh_cycle")
    assert "transmission_error_loaded [arcsec]" in read.columns and "wear_step" in read.columns
    np.testing.assert_allclose(read.to_numpy(float), own.to_numpy(float), rtol=1e-14)
    pytest.importorskip("openpyxl", reason="extra tables: workbooks are written by openpyxl")
    sw.export(tree, tmp_path / "a.xlsx")
    sheets = pd.read_excel(tmp_path / "a.xlsx", sheet_name=None)
    assert list(sheets) == ["history", "engagement", "mesh_cycle", "diagnostics", "about"]
    np.testing.assert_allclose(
        sheets["history"]["wear_volume[gear] [mm^3]"], tree["history"].wear_volume.sel(body="gear").values
    )
    about = sheets["about"].set_index(["table", "column"])
    assert about.loc[("engagement", "load_share"), "meaning"] == "share of the load on the tooth pair"


# ---- surfaces


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_a_worn_flank_lies_below_the_unworn_one_by_its_wear(tree, body, tmp_path):
    sw.export(tree, tmp_path / "worn.vtu", body=body)
    sw.export(tree, tmp_path / "new.vtu", body=body, wear_step=0)
    worn, new = pyvista.read(tmp_path / "worn.vtu"), pyvista.read(tmp_path / "new.vtu")
    apart = np.linalg.norm(np.asarray(worn.points) - np.asarray(new.points), axis=1)
    depth = tree["flank"].wear_depth.isel(wear_step=-1).sel(body=body).transpose("face", "profile").values.ravel()
    np.testing.assert_allclose(1e3 * apart, depth, atol=1e-8)
    np.testing.assert_allclose(worn["wear_depth [um]"], depth)
    np.testing.assert_allclose(worn["wear_depth_step_1 [um]"], new["wear_depth_step_1 [um]"])
    # facets look out of the material, and wear moved them into it
    normals = new.extract_surface(algorithm="dataset_surface").compute_normals(
        auto_orient_normals=False, consistent_normals=False
    )
    moved = np.asarray(worn.points) - np.asarray(new.points)
    deep = depth > 0.2 * depth.max()
    assert np.all(np.einsum("ij,ij->i", moved, normals.point_data["Normals"])[deep] < 0.0)


@pytest.mark.parametrize("which", ["tree", pytest.param("face_tree", marks=pytest.mark.slow)])
def test_a_whole_tooth_is_closed_and_lighter_by_its_wear(which, request, tmp_path):
    tree = request.getfixturevalue(which)
    for name, step in (("new", 0), ("worn", -1)):
        sw.export(tree, tmp_path / f"{name}.vtu", part="tooth", wear_step=step)
    new, worn = (
        pyvista.read(tmp_path / f"{name}.vtu").extract_surface(algorithm="dataset_surface")
        for name in ("new", "worn")
    )
    assert new.is_manifold and new.n_open_edges == 0
    sw.export(tree, tmp_path / "worn.stl", part="tooth")
    facets = pyvista.read(tmp_path / "worn.stl")
    assert facets.is_manifold and facets.volume == pytest.approx(worn.volume, rel=1e-4)
    lost = float(tree["history"].wear_volume.isel(wear_step=-1).sel(body="gear"))
    # the map ends where the roundings of the edges begin; the mesh carries the wear on to sharp edges, and down to
    # the first node of the fillet
    assert lost < new.volume - worn.volume < 1.2 * lost
    # tip land and end faces stay where they were, but for the chord along which the tip's edge slides
    np.testing.assert_allclose(new.bounds, worn.bounds, rtol=0.0, atol=1e-3)
    flank = sw.worn_flank(tree, wear_step=0)
    off = pyvista.PolyData(flank.points).compute_implicit_distance(new)["implicit_distance"]
    assert np.abs(off).max() < 1e-3  # mm, that facets cut off


def test_a_body_wider_than_its_mate_is_not_worn_beyond_it(tmp_path):
    widths = {"gear_pair.pinion_face_width_mm": 24.0, "gear_pair.gear_face_width_mm": 18.0}
    coarse = {"numerics.face_slices": 9, "numerics.wear_steps": 1, "numerics.tooth_compliance": "rigid"}
    scene = SPUR.replace(widths | coarse)
    tree = sw.simulate(scene)
    teeth = [sw.worn_tooth(tree, "pinion", step) for step in (0, 1)]
    lost = float(tree["history"].wear_volume.isel(wear_step=-1).sel(body="pinion"))
    assert lost < volume(teeth[0]) - volume(teeth[1]) < 1.2 * lost  # it was 1.5 times as much
    worn = teeth[1].fields["wear_depth"] > 0.0
    assert 8.0 < np.abs(teeth[1].points[worn, 2]).max() < 9.0
    for name, given in (("new", None), ("worn", tree)):
        sw.export_flank(scene, "pinion", tmp_path / f"{name}.nc", points=(21, 49), worn=given)
    new, worn = (xr.load_dataset(tmp_path / f"{name}.nc").points for name in ("new", "worn"))
    depth = np.linalg.norm(worn - new, axis=-1).max(axis=0)
    aside = np.abs(new.values[10, :, 2]) >= 9.0
    assert aside.sum() == 14 and not depth[aside].any() and depth[~aside].all()


def volume(surface):
    """Volume within a closed surface [mm^3]."""
    corners = surface.points[surface.quads]
    return sum(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, k], corners[:, k + 1])) / 6.0 for k in (1, 2))


def test_a_series_has_every_wear_step_at_its_meshes(tree, tmp_path):
    sw.export(tree, tmp_path / "life.pvd", exaggeration=100.0)
    reader = pyvista.get_reader(str(tmp_path / "life.pvd"))
    assert reader.time_values == list(tree["flank"].meshes.values)
    reader.set_active_time_value(reader.time_values[1])
    (mesh,) = reader.read()
    np.testing.assert_allclose(mesh["wear_depth [um]"], mesh["wear_depth_step_1 [um]"])


def test_zones_are_those_of_the_history(tree):
    for zone in ("root", "pitch", "addendum"):
        deepest = sw.in_zone(tree, zone).wear_depth.max(("profile", "face"))
        assert float(deepest[-1]) <= float(tree["history"][f"wear_depth_max_{zone}"][-1]) + 1e-9
    assert float(sw.in_zone(tree, "root").wear_depth.max()) > 0.0


def test_the_contact_pattern_in_a_zone_is_the_gears():
    tree = synthetic_tree()
    assert "contact_pattern" in sw.in_zone(tree, "root")
    assert "contact_pattern" not in sw.in_zone(tree, "root", "pinion")
    with pytest.raises(sw.SceneError, match="2 problems"):
        sw.in_zone(tree, "tip", "wheel")


# ---- mesh stiffness


def test_mesh_stiffness_gives_back_the_loaded_transmission_error(tree):
    found = sw.mesh_stiffness(tree)
    force = found.attrs["normal_force_N"]
    assert force * found.attrs["lever_arm_mm"] == pytest.approx(1e3 * SPUR.operation.pinion_torque_Nm)
    approach = found.transmission_error_unloaded - found.transmission_error_loaded
    np.testing.assert_allclose(1e-3 * found.mesh_stiffness * approach, force)
    np.testing.assert_allclose(
        found.torsional_mesh_stiffness, 1e-3 * found.mesh_stiffness * found.attrs["lever_arm_mm"] ** 2
    )
    # Hertz: an approach that grows less than the load; worn flanks more so
    assert np.all(found.mesh_stiffness_local > found.mesh_stiffness)


def test_the_local_stiffness_is_the_slope_of_loaded_contact(tree):
    found = sw.mesh_stiffness(tree).isel(wear_step=0)
    errors = []
    for factor in (0.98, 1.02):
        scene = SPUR.replace({"operation.pinion_torque_Nm": factor * SPUR.operation.pinion_torque_Nm})
        loaded = sw.loaded_contact(scene, found.mesh_position.values)
        errors.append(loaded["mesh_cycle"].transmission_error_loaded.isel(wear_step=0).values)
    angle = np.radians((errors[0] - errors[1]) / 3600.0) * 24.0 / 16.0  # of the pinion
    slope = 0.04 * SPUR.operation.pinion_torque_Nm / angle
    np.testing.assert_allclose(found.torsional_mesh_stiffness_local, slope, rtol=2e-3)


def test_stiffness_over_angle_is_periodic(tree):
    found = sw.mesh_stiffness(tree, local=False)
    stiffness = sw.stiffness_over_angle(found, 0)
    angle = np.radians(found.pinion_angle.values)
    np.testing.assert_allclose(stiffness(angle), found.mesh_stiffness.isel(wear_step=0))
    np.testing.assert_allclose(stiffness(angle + 2.0 * np.pi), stiffness(angle))
    last = sw.stiffness_over_angle(found.isel(wear_step=-1))
    np.testing.assert_array_equal(last(angle), found.mesh_stiffness.isel(wear_step=-1))
    with pytest.raises(sw.SceneError, match="below 1"):
        sw.stiffness_over_angle(found.isel(wear_step=-1), 1)
    with pytest.raises(sw.SceneError, match="mesh_stiffness_local"):
        sw.stiffness_over_angle(found, of="mesh_stiffness_local")


def test_stiffness_leaves_as_a_table(tree, tmp_path):
    sw.export(tree, tmp_path / "k.csv", table="mesh_stiffness")
    read = pd.read_csv(tmp_path / "k.csv")
    found = sw.mesh_stiffness(tree)
    assert len(read) == found.mesh_stiffness.size
    np.testing.assert_allclose(read["mesh_stiffness_local [N/mm]"], found.mesh_stiffness_local.values.ravel())


# ---- input decks


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_forces_of_a_deck_balance_the_torque(tree, body, tmp_path):
    sw.export(tree, tmp_path / "a.inp", body=body, teeth=3)
    places, forces, data = {}, [], ""
    for line in (tmp_path / "a.inp").read_text().splitlines():
        if line.startswith("*"):
            data = line
        elif data == "*NODE":
            number, *place = line.split(",")
            places[int(number)] = np.array(place, float)
        elif data == "*CLOAD":
            node, axis, value = line.split(",")
            forces.append((places[int(node)], int(axis) - 1, float(value)))
    moment = sum(np.cross(place, value * np.eye(3)[axis]) for place, axis, value in forces)
    ratio = 1.0 if body == "pinion" else 24.0 / 16.0
    assert abs(moment[2]) == pytest.approx(1e3 * SPUR.operation.pinion_torque_Nm * ratio, rel=1e-3)
    heads = re.findall(r"^\*(?:NSET|MATERIAL|STATIC|BOUNDARY).*", (tmp_path / "a.inp").read_text(), re.M)
    assert {"*NSET,NSET=HELD", "*NSET,NSET=FLANK", "*NSET,NSET=FILLET"} <= set(heads)


def test_forces_of_a_deck_are_those_of_the_result(tree):
    step, roll = 2, float(tree["engagement"].roll_position[12])
    loads = contact_loads(tree, "gear", step, roll)
    data = tree["engagement"].isel(wear_step=step)
    force = (data.line_load * data.line_length).sum("face")
    for load in loads:
        ahead = -load.tooth
        told = float(force.sel(roll_position=roll + ahead, method="nearest"))
        assert load.force.sum() == pytest.approx(told, rel=1e-3)


def test_nodes_are_on_the_flank(face_tree):
    for body, index in (("pinion", 0), ("gear", 1)):
        nodes = flank_nodes(face_tree, body)
        points, _ = own_flank(nodes.flank.pair, index, nodes.face[:, None], nodes.profile)
        radius = face_tree["flank"].flank_radius.sel(body=body).transpose("face", "profile").values
        np.testing.assert_allclose(np.hypot(points[..., 0], points[..., 1]), radius, rtol=1e-12)


# ---- what is refused


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("a.docx", {}, "a.vtu"),
        ("a.vtu", {"body": "wheel", "part": "rim"}, "2 problems"),
        ("a.docx", {"body": "wheel", "exaggeration": -1.0}, "3 problems"),
        ("a.vtu", {"wear_step": 7}, "below 3"),
        ("a.vtu", {"exaggeration": 0.0}, "> 0"),
        ("a.csv", {"table": "wear"}, '"history"'),
        ("a.csv", {"table": "life"}, "take one that this result has"),
        ("a.inp", {"roll_position": 9.0}, "roll_position"),
        ("a.inp", {"roll_position": 0.5, "teeth": 1}, "3 or more"),
        ("a.inp", {"teeth": 0}, "or more"),
        ("none/a.csv", {}, "none"),
    ],
)
def test_what_cannot_be_exported_is_refused(tree, name, arguments, words, tmp_path):
    with pytest.raises((sw.SemiwearError, OSError), match=words):
        sw.export(tree, tmp_path / name, **arguments)


def test_results_without_wear_have_no_surfaces(tmp_path):
    contact = sw.loaded_contact(SPUR)
    with pytest.raises(sw.SceneError, match="/flank/wear_depth"):
        sw.export(contact, tmp_path / "a.stl")
    sw.export(contact, tmp_path / "a.csv", table="mesh_stiffness")
    assert "mesh_stiffness [N/mm]" in pd.read_csv(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("name", "package", "extra"), [("a.vtu", "meshio", "view"), ("a.xlsx", "openpyxl", "tables")]
)
def test_missing_packages_name_their_extra(tree, name, package, extra, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"semiwear\[{extra}\]"):
        sw.export(tree, tmp_path / name)


def test_the_command_exports(tree, tmp_path, capsys):
    sw.save(tree, tmp_path / "worn.nc")
    out = tmp_path / "tooth.stl"
    command = ["export", str(tmp_path / "worn.nc"), "-o", str(out), "--part", "tooth", "--body", "pinion"]
    assert main(command) == 0 and capsys.readouterr().out == f"export: {out}\n"
    assert pyvista.read(out).is_manifold
    assert main([*command[:3], str(tmp_path / "worn.nc")]) == 2
    assert "a file of its own" in capsys.readouterr().err

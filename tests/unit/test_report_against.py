import re

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear import cli, plot
from semiwear.errors import SemiwearError
from semiwear.plot.flank_regions import Region, flank_regions
from semiwear.plot.two_results import TwoResults
from semiwear.report import fidelities, write_report
from semiwear.report import page as report_page
from semiwear.report.differences import LOAD_SHARE, RELATIVE, Kind, Mark, differences
from semiwear.report.fidelities import against_section
from semiwear.report.reasons import PEAK, RELIEVES, TAKES_MORE, reason
from tests.strategies.results import SCENE, changed, of_one_state, synthetic_tree, without

SMALL = {
    "numerics.face_slices": 31,
    "numerics.roll_positions": 12,
    "numerics.cells_per_half_width": 4,
    "wear.until.control_depths_um": [5.0, 10.0],
}


def result(fidelity="line", wear_steps=3, scene_toml=SCENE, **sizes):
    """A synthetic result that says it has a fidelity."""
    stated = scene_toml + f'\n[numerics]\nfidelity = "{fidelity}"\n'
    tree = synthetic_tree(wear_steps, scene_toml=stated, **sizes)
    tree.attrs["fidelity"] = fidelity
    return tree


def with_meshes(tree, factor):
    """A copy in which every wear step takes another number of meshes."""
    copy = tree.copy(deep=True)
    for group in copy.children:
        dataset = copy[group].to_dataset()
        if "meshes" in dataset.coords:
            meshes = ("wear_step", factor * dataset["meshes"].values)
            copy[group] = xr.DataTree(dataset.assign_coords(meshes=meshes))
    return copy


def rows_of(this, other, **chosen):
    rows = differences(TwoResults.of(this, other))
    return [row for row in rows if all(getattr(row, name) == value for name, value in chosen.items())]


def marks_of(this, other, **chosen):
    return {row.mark for row in rows_of(this, other, **chosen)}


def words(this, other, kind, alike=True):
    results = TwoResults.of(this, other)
    return reason(kind, differences(results), results, alike)


def section(path):
    text = path.read_text(encoding="utf-8")
    begin = text.index("<h2>Against fidelity")
    return text[begin : text.index("</section>", begin)]


@pytest.fixture(scope="module")
def line():
    return result("line")


@pytest.fixture(scope="module")
def patch():
    return result("patch")


@pytest.fixture(scope="module")
def real():
    """Small results of the shipped scene at both fidelities."""
    scene = sw.load_scene("face_gear_25x160").replace(SMALL)
    return {fidelity: sw.simulate(scene, fidelity=fidelity) for fidelity in ("line", "patch")}


# ---------------------------------------------------------------------- marks


def test_equal_results_agree_everywhere(line, patch):
    rows = rows_of(line, patch)
    assert {row.mark for row in rows} == {Mark.AGREE}
    assert {row.kind for row in rows} == set(Kind)
    assert all(row.size == 0.0 for row in rows)


@pytest.mark.parametrize(
    ("path", "chosen"),
    [
        ("history/contact_pressure_root", {"where": "root", "quantity": "greatest pressure"}),
        ("history/contact_pressure_pitch", {"where": "pitch"}),
        ("history/contact_pressure_addendum", {"where": "addendum", "quantity": "greatest pressure"}),
        ("engagement/contact_pressure_max", {"kind": Kind.PRESSURE, "where": "away from borders"}),
        ("engagement/contact_pressure_max_edge", {"kind": Kind.PRESSURE, "border": True}),
        ("history/wear_depth_max_root", {"where": "root", "quantity": "greatest wear depth, gear"}),
        ("history/wear_depth_max_addendum", {"where": "addendum", "quantity": "greatest wear depth, gear"}),
        ("engagement/root_stress", {"kind": Kind.ROOT_STRESS}),
        ("engagement/line_load", {"quantity": "greatest line load"}),
        ("mesh_cycle/transmission_error_loaded", {"kind": Kind.TRANSMISSION_ERROR}),
    ],
)
@pytest.mark.parametrize("direction", [1, -1])
def test_a_known_difference_gets_its_mark_both_ways(line, patch, path, chosen, direction):
    def pair(factor):
        other = changed(patch, path, lambda values: factor * values)
        return (line, other) if direction > 0 else (other, line)

    just_within, just_beyond = (1.0 / (1.0 - RELATIVE * share) for share in (0.99, 1.01))
    assert marks_of(*pair(just_within), **chosen) == {Mark.AGREE}
    assert marks_of(*pair(just_beyond), **chosen) == {Mark.DIFFER}
    rows = rows_of(*pair(2.0))
    row = next(row for row in rows if all(getattr(row, name) == chosen[name] for name in chosen))
    assert row.text.startswith("−50.0 %" if direction > 0 else "+50.0 %") or row.this < 0
    others = [row for row in rows if any(getattr(row, name) != chosen[name] for name in chosen)]
    assert {row.mark for row in others} == {Mark.AGREE}


@pytest.mark.parametrize(("apart", "mark"), [(0.95, Mark.AGREE), (1.05, Mark.DIFFER)])
def test_load_shares_are_compared_as_they_are(line, patch, apart, mark):
    def add(values):
        values[-1, 20] += apart * LOAD_SHARE
        return values

    (row,) = rows_of(line, changed(patch, "engagement/load_share", add), kind=Kind.LOAD, units="1", when="last")
    roll = float(line["engagement"]["roll_position"].values[20])
    assert row.mark is mark and abs(row.size + apart * LOAD_SHARE) < 1e-12
    assert row.where == f"roll position {roll:+.2f}".replace("-", "−")


def test_load_shares_on_other_roll_positions_are_interpolated(line):
    finer = result("patch", mesh_positions=24)
    (row,) = rows_of(line, finer, kind=Kind.LOAD, units="1", when="unworn")
    assert 0.0 < abs(row.size) < LOAD_SHARE


@pytest.mark.parametrize("body", ["pinion", "gear"])
@pytest.mark.parametrize("region", list(Region))
def test_wear_is_compared_region_by_region(line, patch, region, body):
    k = ("pinion", "gear").index(body)
    points = flank_regions(TwoResults.of(line, patch), body).points[region]
    greatest = float(line["flank"]["wear_depth"].values[-1, k].max())
    at = tuple(np.argwhere(points)[len(np.argwhere(points)) // 2])

    def dig(values):
        values[-1, k][at] += 0.05 * greatest
        return values

    rows = rows_of(line, changed(patch, "flank/wear_depth", dig))
    compared = [row for row in rows if row.quantity.startswith("wear depth where it differs most")]
    assert len(compared) == 2 * len(Region)
    for row in compared:
        assert row.mark is (Mark.DIFFER if (row.region, row.body) == (region, body) else Mark.AGREE)
        assert row.border is (row.region is not Region.INSIDE)


def test_regions_cover_the_flank_once(line, patch):
    regions = flank_regions(TwoResults.of(line, patch))
    assert (sum(points.astype(int) for points in regions.points.values()) == 1).all()
    height = line["flank"]["flank_height"].values[1]
    assert regions.points[Region.TIP][height[:, 5] > height[:, 5].max() - 0.99 * regions.width, 5].all()
    assert not regions.points[Region.TIP][height[:, 5] < height[:, 5].max() - 1.01 * regions.width, 5].any()
    assert regions.points[Region.FACE_ENDS][20, [0, -1]].all() and regions.points[Region.CORNERS][0, 0]


def test_equal_states_are_found_by_depth_or_by_meshes(line):
    longer = with_meshes(result("patch", wear_steps=5), 1.1)
    assert TwoResults.of(line, longer).steps == ((0, 0), (1, 1), (2, 2))
    far = changed(longer, "history/wear_depth_control_point", lambda values: 1.3 * values)
    assert TwoResults.of(line, far).steps == ((0, 0),)
    same_meshes = with_meshes(far, 1 / 1.1)
    assert TwoResults.of(line, same_meshes).steps == ((0, 0), (1, 1), (2, 2))
    every_other = result("patch", wear_steps=5)
    every_other = every_other.map_over_datasets(
        lambda group: group.isel(wear_step=[0, 2, 4]) if "wear_step" in group.dims else group
    )
    assert TwoResults.of(line, every_other).steps == ((0, 0), (2, 1))


# ---------------------------------------------------------------------- reasons


def test_reasons_say_what_the_numbers_say(line, patch):
    assert "agree within 0.0 %" in words(line, patch, Kind.PRESSURE)
    assert "differ" not in words(line, patch, Kind.ROOT_STRESS)
    near = changed(patch, "history/contact_pressure_root", lambda v: 1.02 * v)
    assert "differ" not in words(line, near, Kind.PRESSURE)
    worn = changed(patch, "history/contact_pressure_root", lambda v: v * np.array([1.0, 1.0, 1.2]))
    text = words(line, worn, Kind.PRESSURE)
    assert "differ by up to 16.7 % (1 of 8 values differ)" in text and "agree unworn: the difference arises" in text
    fresh = changed(patch, "history/contact_pressure_root", lambda v: v * np.array([1.2, 1.0, 1.0]))
    assert "before any wear" in words(line, fresh, Kind.PRESSURE)
    bent = changed(patch, "engagement/root_stress", lambda v: v * np.array([1.0, 1.0, 1.1])[:, None, None])
    assert "agree unworn" in words(line, bent, Kind.ROOT_STRESS)
    bent = changed(patch, "engagement/root_stress", lambda v: 1.1 * v)
    assert "where the load acts on them" in words(line, bent, Kind.ROOT_STRESS)


@pytest.mark.parametrize("more", [0.9, 1.1])
@pytest.mark.parametrize("less", [0.9, 1.1])
@pytest.mark.parametrize("patch_first", [False, True])
def test_an_edge_takes_load_only_where_the_numbers_show_it(line, patch, more, less, patch_first):
    other = changed(patch, "engagement/load_share", lambda v: v + more * TAKES_MORE)
    other = changed(other, "engagement/contact_pressure_max", lambda v: (1.0 - less * RELIEVES) * v)
    text = words(*((other, line) if patch_first else (line, other)), Kind.PRESSURE)
    assert ("the edge carries more load" in text) is (more > 1)
    assert ("relieves" in text) is (less > 1) or "does not relieve" in text
    assert ("no shift of load" in text) is (more < 1 and less < 1)


def test_a_peak_of_one_slice_is_named(line, patch):
    def peak(values):
        values[-1, 20, 10] = 1.1 * PEAK * values.max()
        return values

    smooth = changed(patch, "engagement/line_load", lambda v: 1.5 * v)
    assert "a peak of one slice" not in words(line, smooth, Kind.LOAD)
    text = words(line, changed(patch, "engagement/line_load", peak), Kind.LOAD)
    assert "is a peak of one slice (in `patch`" in text


def test_no_reason_is_given_by_fidelity_where_the_scenes_differ_otherwise(line, patch):
    pressed = changed(patch, "engagement/contact_pressure_max_edge", lambda v: 0.5 * v)
    assert "Hertz" in words(line, pressed, Kind.PRESSURE)
    for text in (
        words(line, pressed, Kind.PRESSURE, alike=False),
        words(line, changed(line, "engagement/contact_pressure_max_edge", lambda v: 0.5 * v), Kind.PRESSURE),
    ):
        assert "Hertz" not in text and "look for the reason in the scenes" in text


def test_other_engagements_for_the_same_depth_are_told(line, patch):
    text = words(line, with_meshes(patch, 1.1), Kind.WEAR)
    assert "same wear at the control point" in text and "(−9.1 %)" in text
    assert "engagements (" not in words(line, patch, Kind.WEAR)


@pytest.mark.parametrize(("body", "factor"), [("pinion", 2.0), ("gear", 0.5)])
def test_sentences_on_wear_tell_both_bodies(line, patch, body, factor):
    """The greatest depth of one body differs by a half: the sentences of the other agree."""
    stem = "wear_depth_max_pinion" if body == "pinion" else "wear_depth_max"
    other = changed(patch, f"history/{stem}_root", lambda v: factor * v)
    text = words(line, other, Kind.WEAR)
    for one in ("pinion", "gear"):
        told = "differ by up to 50.0 % (1 of 3 values differ)" if one == body else "agree within 0.0 %"
        assert f"Greatest depths of the {one} {told}." in text
        assert f"Away from borders the maps of the {one} agree within 0.0 % of the greatest wear." in text


def test_a_gear_that_does_not_wear_is_not_compared():
    scene = SCENE + 'worn_bodies = ["pinion"]\n'
    line, patch = (result(fidelity, scene_toml=scene) for fidelity in ("line", "patch"))
    rows = [row for row in rows_of(line, patch, kind=Kind.WEAR) if row.body]
    assert rows and {row.body for row in rows} == {"pinion"}
    assert "of the gear" not in words(line, patch, Kind.WEAR)


# ---------------------------------------------------------------------- page


@pytest.mark.slow
def test_the_section_stands_in_the_page(tmp_path, line, patch, unseen):
    other = changed(patch, "engagement/contact_pressure_max_edge", lambda v: 0.5 * v)
    text = section(sw.report(line, tmp_path / "r.html", against=other))
    assert "Against fidelity “patch”" in text and "<code>numerics.fidelity</code> only" in text
    assert "differ" in text and "borders: tips, ends, corners" in text
    assert text.count("<img") == 3 and "http" not in text  # the wear of both bodies, and pressures
    assert re.search(r"✗ differ</td>", text) and 'class="disagree"' in text
    back = section(sw.report(other, tmp_path / "r.html", against=line))
    assert "Against fidelity “line”" in back
    assert "Against fidelity" not in sw.report(line, tmp_path / "r.html").read_text(encoding="utf-8")


def test_fields_that_differ_are_listed(line, monkeypatch, unseen):
    other = result("patch", scene_toml=SCENE.replace("pinion_torque_Nm = 1600", "pinion_torque_Nm = 800"))
    text = against_section(line, other)
    assert "operation.pinion_torque_Nm" in text and ">1600<" in text and ">800<" in text
    assert "Both fidelities" not in text and "<img" in text
    monkeypatch.setattr(fidelities, "_pictures", lambda results: "")
    same = against_section(line, line)
    assert "The scenes are the same" in same and '<th scope="col">this</th>' in same
    unreadable = line.copy(deep=True)
    unreadable.attrs["scene_toml"] = "no = toml = at all"
    assert "no readable scene" in against_section(unreadable, line)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("group", "name", "kind"),
    [
        ("engagement", "contact_pressure_max_edge", Kind.PRESSURE),
        ("engagement", "root_stress", Kind.ROOT_STRESS),
        ("history", "wear_depth_max_root", Kind.WEAR),
    ],
)
def test_missing_variables_are_not_compared(line, patch, group, name, kind, unseen):
    lacking = without(patch, group, name)
    rows = rows_of(line, lacking, mark=Mark.NOT_COMPARED)
    assert rows and {row.kind for row in rows} == {kind}
    assert all(f"no /{group}/{name} in patch" in row.text for row in rows)
    assert "– not compared" in against_section(line, lacking)


def test_without_line_loads_the_borders_have_no_width(line, patch):
    rows = rows_of(without(line, "engagement", "line_load"), without(patch, "engagement", "line_load"))
    assert {row.region for row in rows if row.mark is Mark.NOT_COMPARED} == set(Region)
    assert not [row for row in rows if row.quantity == "greatest line load"]


@pytest.mark.slow
@pytest.mark.parametrize("swapped", [False, True])
def test_loaded_contact_alone_is_compared_in_what_both_have(tmp_path, line, patch, swapped, unseen):
    contact = of_one_state(patch)
    for group in ("flank", "history", "diagnostics"):
        contact = without(contact, group)
    pair = (contact, line) if swapped else (line, contact)
    rows = rows_of(*pair)
    assert {row.kind for row in rows} == set(Kind) - {Kind.WEAR}
    assert {row.mark for row in rows} == {Mark.AGREE} and {row.when for row in rows} == {"as given"}
    text = section(write_report(pair[0], tmp_path / "r.html", pair[1]))
    assert text.count("<img") == 1 and "Difference in wear, gear is left out" in text


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ({"faces": 31}, "face has 33 points here and 31 there; make both with the same numerics.face_slices"),
        (
            {"profiles": 39},
            "profile has 41 points here and 39 there; make both with the same numerics.profile_points",
        ),
        ({"faces": 31, "profiles": 39}, "the same numerics.face_slices and numerics.profile_points"),
    ],
)
def test_other_flank_grids_are_refused(tmp_path, line, sizes, said, monkeypatch):
    monkeypatch.setattr(report_page, "_sections", None)  # before a section is made
    with pytest.raises(SemiwearError, match=re.escape(said)):
        write_report(line, tmp_path / "r.html", result("patch", **sizes))
    assert not list(tmp_path.iterdir())


def test_other_flanks_and_foreign_trees_are_refused(tmp_path, line, patch):
    with pytest.raises(SemiwearError, match=r"different flanks.*/flank/flank_height differs by up to 0\.5 mm"):
        write_report(line, tmp_path / "r.html", changed(patch, "flank/flank_height", lambda v: v + 0.5))
    with pytest.raises(SemiwearError, match="`against` has no schema_version"):
        write_report(line, tmp_path / "r.html", xr.DataTree())


# ---------------------------------------------------------------------- pictures


def test_pictures_of_two_results(line, patch):
    deeper = changed(patch, "flank/wear_depth", lambda v: 1.2 * v)
    panel = plot.against.wear_difference(line, deeper)
    (mesh, *_) = panel.collections
    low, high = mesh.get_clim()
    assert low == -high and mesh.get_array().min() == pytest.approx(low) and mesh.get_array().max() <= 1e-12
    assert "line minus patch" in panel.get_title(loc="left")
    panel = plot.against.pressure_of_both(line, deeper)
    assert len(panel.texts) == 4 and panel.get_yscale() == "linear"
    edges = changed(patch, "engagement/contact_pressure_max_edge", lambda v: 10 * v)
    assert plot.against.pressure_of_both(line, edges).get_yscale() == "log"
    with pytest.raises(SemiwearError, match="no worn flank in common"):
        plot.against.wear_difference(result(wear_steps=1), patch)


# ---------------------------------------------------------------------- shipped scene and command line


@pytest.mark.slow
def test_both_fidelities_of_a_real_scene(real, tmp_path, unseen):
    rows = rows_of(real["line"], real["patch"])
    unworn = [row for row in rows if row.when == "unworn" and not row.border]
    assert unworn and {row.mark for row in unworn} == {Mark.AGREE}
    (edge,) = [row for row in rows if row.kind is Kind.PRESSURE and row.border and row.when == "unworn"]
    assert edge.mark is Mark.DIFFER and edge.this > edge.other
    regions = flank_regions(TwoResults.of(real["line"], real["patch"]))
    assert regions.width == pytest.approx(1.05, rel=0.08)
    text = section(write_report(real["patch"], tmp_path / "r.html", real["line"]))
    assert "<code>numerics.fidelity</code> only" in text and text.count("<img") == 2


@pytest.fixture
def files(real, tmp_path):
    paths = {}
    for fidelity, tree in real.items():
        paths[fidelity] = tmp_path / f"{fidelity}.nc"
        sw.save(tree, paths[fidelity])
    return paths


@pytest.mark.slow
def test_report_against_a_file(files, tmp_path, capsys, unseen):
    assert cli.main(["report", str(files["line"]), "--against", str(files["patch"])]) == 0
    assert "Against fidelity “patch”" in (tmp_path / "line.html").read_text(encoding="utf-8")
    assert cli.main(["report", str(files["line"]), "--against", str(tmp_path / "none.nc")]) == 2
    assert "none.nc" in capsys.readouterr().err


def changes():
    texts = [f"{key}={value}" for key, value in SMALL.items()]
    return [part for text in texts for part in ("--set", text)]


@pytest.mark.slow
def test_run_with_a_fidelity_against_a_file(files, tmp_path, capsys, unseen):
    page = tmp_path / "p.html"
    options = ["--fidelity", "patch", "--report", str(page), "--against", str(files["line"])]
    assert cli.main(["run", "face_gear_25x160", *changes(), *options]) == 0
    assert "Against fidelity “line”" in page.read_text(encoding="utf-8")
    given = ["--fidelity", "line", "--set", "numerics.fidelity=line", "-o", str(tmp_path / "o.nc")]
    assert cli.main(["run", "face_gear_25x160", *changes(), *given]) == 0
    assert sw.open_results(tmp_path / "o.nc").attrs["fidelity"] == "line"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--fidelity", "patch", "--set", "numerics.fidelity=line"], "--fidelity: found 'patch'"),
        (["--fidelity", "coarse"], "numerics.fidelity: found 'coarse'"),
        (["--against", "other.nc"], "add --report FILE"),
        (["--report", "r.html", "--against", "nowhere.nc"], "nowhere.nc"),
    ],
)
def test_options_that_do_not_fit_are_errors(options, said, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sw, "simulate", lambda *_, **__: pytest.fail("nothing may be computed"))
    assert cli.main(["run", "face_gear_25x160", *options]) == 2
    assert said in capsys.readouterr().err

"""The validation report: sections that fail are shown, data are written, and what it computes is right."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import numpy as np
import pytest
import xarray as xr
from site_pages.validated import findings

import semiwear as sw
from semiwear.errors import ResultFileError
from validation import __main__ as command
from validation import finite_elements as store
from validation.accuracy_time import Point, cost_of_a_digit, points_of
from validation.charts import card, pareto
from validation.parallel import build_all
from validation.problems import FIGURES, METHODS, PROBLEMS, WEAR_PROBLEMS, BlockOnRing, Setting
from validation.progress import NoProgress, progress_on
from validation.section import Section, SectionPlan
from validation.sections import SECTIONS, accuracy_time, failure_modes, finite_elements, peers
from validation.sections.block_on_ring import ring_run
from validation.sections.paper_steps import explained
from validation.sections.paper_torque import FIGURES as FIGURES_OF_THE_PAPER
from validation.sections.paper_torque import figures_of
from validation.tables import dataset, failures_note
from validation.torque_inference import best_torque, inferred_torque
from validation.wear_schemes import SchemeRun, solves_for
from validation.writer import page, write

# ---- the page


def sound(problems, quick, progress):
    progress.note("counting to three")
    data = dataset(
        {"count": [1, 2, 3]},
        {"square": ([1.0, 4.0, 9.0], "mm", "its square"), "odd": ([True, False, True], "1", "odd")},
    )
    chart = card("squares", "Squares", "They grow.", lambda ax: ax.plot([1, 2, 3], [1, 4, 9]))
    return Section(("Three squares < 10 were found.",), chart, {"squares": data})


def broken(problems, quick, progress):
    raise ValueError("the abacus <broke>")


PLANS = (SectionPlan("counting", "Counting", sound), SectionPlan("broken", "Broken", broken))


def test_the_site_tells_what_sections_found_and_of_one_that_failed():
    told, failed = build_all(PLANS, PROBLEMS, True, NoProgress())
    assert findings([told]).startswith("## Counting\n\n- ")
    with pytest.raises(RuntimeError, match="the abacus <broke>"):
        findings([told, failed])


class Ids(HTMLParser):
    """Ids and references to them, and tags that are not closed."""

    VOID = frozenset(("meta", "br", "img", "path", "use", "rect", "link"))

    def __init__(self):
        super().__init__()
        self.ids, self.references, self.open = [], [], []

    def handle_starttag(self, tag, attributes):
        self.open += [tag] if tag not in self.VOID else []
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("href", "xlink:href") and value.startswith("#"):
                self.references.append(value[1:])
            self.references += re.findall(r"url\(#([^)]+)\)", value or "")

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def parts():
    return build_all(PLANS, PROBLEMS, True, NoProgress())


def test_a_section_that_fails_is_seen_and_the_others_stand(parts):
    text = page(parts, quick=True)
    assert "Three squares &lt; 10 were found." in text
    assert "This section could not be built." in text
    assert "ValueError: the abacus &lt;broke&gt;" in text
    assert [part.error != "" for part in parts] == [False, True]


def test_the_page_is_whole_and_needs_nothing_else(parts):
    text = page(parts, quick=True)
    seen = Ids()
    seen.feed(text)
    assert seen.open == []
    assert len(set(seen.ids)) == len(seen.ids)
    assert set(seen.references) <= set(seen.ids)
    assert not re.search(r'(src|href)="https?:', text)
    assert "<svg" in text


def test_data_are_written_as_netcdf_and_csv(parts, tmp_path):
    target = write(parts, tmp_path / "new" / "folder", quick=True)
    assert target.name == "validation.html"
    with xr.open_datatree(target.with_name("validation.nc")) as tree:
        squares = tree["/counting/squares"]["square"]
        np.testing.assert_array_equal(squares, [1.0, 4.0, 9.0])
        assert squares.attrs == {"units": "mm", "long_name": "its square"}
    lines = target.with_name("counting_squares.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].split(",") == ["count", "square", "odd"]
    assert len(lines) == 4
    assert not list(target.parent.glob(".*"))


def test_the_command_ends_with_status_1_where_a_section_fails(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(command, "SECTIONS", PLANS)
    assert command.main(["--quick", "-o", str(tmp_path), "--jobs", "1"]) == 1
    assert "the abacus" in capsys.readouterr().err
    assert command.main(["--quick", "-o", str(tmp_path), "--jobs", "1", "--sections", "counting"]) == 0
    assert (tmp_path / "validation.html").is_file()


@pytest.mark.slow
def test_processes_build_the_same_sections(parts):
    heard = []

    class Hears(NoProgress):
        def section(self, title):
            heard.append(title)

    for mine, theirs in zip(parts, build_all(PLANS, PROBLEMS, True, Hears(), jobs=2), strict=True):
        assert (theirs.plan.name, theirs.error) == (mine.plan.name, mine.error)
        if mine.section is not None:
            assert theirs.section.html == mine.section.html
    assert sorted(heard) == ["Broken", "Counting"]


def test_progress_is_told_in_lines_where_there_is_no_terminal(capsys):
    import sys

    progress = progress_on(sys.stderr, 2)
    progress.section("Counting")
    progress.note("to three")
    progress.close()
    assert "to three" in capsys.readouterr().err


def test_every_section_has_a_name_of_its_own():
    names = [plan.name for plan in SECTIONS]
    assert len(set(names)) == len(names)
    required = {"accuracy_time", "wear_schemes", "paper", "closed_forms", "finite_elements", "peers", "hard_cases"}
    assert required | {"failure_modes"} <= set(names)


@pytest.mark.slow
def test_the_section_of_failure_modes_shows_every_safety_and_its_cause():
    section = failure_modes.build(PROBLEMS, True, NoProgress())
    data = section.datasets["safeties"]
    assert set(data["symbol"].values) == set(failure_modes.CAUSES)
    assert section.html.count("<svg") == len(failure_modes.CAUSES)
    ratio = data["local"] / data["global"]
    assert float(ratio.min()) > 0.6 and float(ratio.max()) < 2.0
    assert all(f"{symbol} spur" in section.found[0] for symbol in failure_modes.CAUSES)


# ---- accuracy against time


def test_the_pareto_front_keeps_what_no_other_beats():
    cost, error = np.array([1.0, 2.0, 3.0, 2.5, 1.0]), np.array([0.1, 0.05, 0.06, 0.01, 0.2])
    assert [float(error[k]) for k in pareto(cost, error)] == [0.1, 0.05, 0.01]


def test_the_cost_of_a_digit_is_that_of_the_straight_line():
    def point(seconds, error, converged=False):
        setting = Setting(8, 15, 61, 9, 2)
        return Point("spur", "line", setting, seconds, {"wear": 1.0}, {"wear": error}, converged)

    points = [point(99.0, 0.0, True), point(1.0, 0.1), point(10.0, 0.01), point(100.0, 0.001)]
    assert cost_of_a_digit(points) == pytest.approx(10.0)
    assert cost_of_a_digit(points[:2]) is None


def test_settings_that_cannot_be_solved_are_told_and_the_others_stand():
    history = xr.Dataset(
        {name: ("wear_step", [0.0, 1.0]) for name in ("wear_depth_max_root", "contact_pressure_root")}
    )
    history["root_stress_max"] = history["transmission_error_mean"] = history["wear_depth_max_root"]
    good = xr.DataTree.from_dict({"/history": history}), 1.0

    def stubborn(scene):
        if scene.numerics.face_slices == METHODS[0].quick_settings[1].face_slices:
            raise sw.ConvergenceError("no end in sight")
        return good

    arguments = WEAR_PROBLEMS[0], METHODS[0], FIGURES, True, NoProgress()
    points, reference, failures = points_of(*arguments, stubborn)
    assert reference is good[0]
    assert len(points) == len(METHODS[0].quick_settings)
    assert len(failures) == 1
    assert "no end in sight" in failures[0]
    assert "no end in sight" in failures_note(failures)
    assert failures_note([]) == ""

    def hopeless(scene):
        raise sw.ConvergenceError("never")

    points, reference, failures = points_of(*arguments, hopeless)
    assert (points, reference, len(failures)) == ([], None, 1)


def test_solutions_for_an_error_are_those_from_which_on_it_is_kept():
    def run(steps, error):
        return SchemeRun("implicit", steps, 1.0, error, 2.0 * error, 1.0, False)

    runs = [run(1, 0.005), run(2, 0.02), run(4, 0.009), run(8, 0.001)]
    assert solves_for(runs, "implicit", 0.01) == 12
    assert solves_for(runs, "implicit", 0.01, "flank_error") == 24
    assert solves_for(runs, "implicit", 1e-4) is None


def test_time_of_finite_elements_that_are_not_stored_is_unknown(monkeypatch, tmp_path):
    monkeypatch.setattr(store, "DATA", tmp_path)
    cost = accuracy_time.finite_element_cost()
    assert np.isnan(cost.seconds)
    assert "No finite-element time" in cost.note


# ---- the paper


def test_torque_is_inferred_where_the_model_gives_the_figure():
    torques = np.geomspace(100.0, 4000.0, 12)
    rising = inferred_torque("stress", 80.0, torques, 0.1 * torques, model=lambda torque: 0.1 * torque)
    assert rising.torques == pytest.approx([800.0], rel=5e-3)
    assert rising.checked == pytest.approx([80.0], rel=5e-3)
    bowl = inferred_torque("amplitude", 2.0, torques, 1.0 + np.log(torques / 632.0) ** 2)
    assert bowl.torques == pytest.approx([632.0 / np.e, 632.0 * np.e], rel=0.02)
    none = inferred_torque("mean", -1.0, torques, 0.1 * torques)
    assert none.torques == ()
    assert none.range == pytest.approx((10.0, 400.0))
    at_a_point = inferred_torque("stress", 0.1 * torques[3], torques, 0.1 * torques)
    assert at_a_point.torques == pytest.approx([torques[3]])


def test_one_torque_fits_several_figures_or_none_does():
    torques = np.geomspace(100.0, 4000.0, 12)
    values = {"stress": 0.1 * torques, "error": -0.01 * torques}
    fits = best_torque({"stress": 120.0, "error": -12.0}, torques, values, 0.1)
    assert fits.fits
    assert fits.torque == pytest.approx(1200.0, rel=0.02)
    apart = best_torque({"stress": 120.0, "error": -4.0}, torques, values, 0.1)
    assert not apart.fits
    # between 400 and 1200, where the two are missed alike
    assert apart.worst == pytest.approx(0.5, rel=0.03)
    assert apart.torque == pytest.approx(600.0, rel=0.03)


# ---- literature


def test_the_block_on_ring_wears_as_published():
    """Abaqus with UMESHMOTION within 1 %, though its contact is two-dimensional finite elements."""
    ring = BlockOnRing.published()
    run = ring_run(ring, 160, 5)
    np.testing.assert_allclose(run.depths, ring.umeshmotion, rtol=0.01)
    np.testing.assert_allclose(run.half_widths, ring.umeshmotion_half_width, atol=0.03)
    # the rigid closed form is the limit of wear that is deep against the elastic approach
    np.testing.assert_allclose(run.depths, ring.rigid, rtol=2e-3)
    # conserved: depth integrated is k F s over the width
    cell = run.place[1] - run.place[0]
    expected = ring.coefficient * ring.line_load * 1e3 * np.array(ring.distances)
    np.testing.assert_allclose(1e-3 * run.wear.sum(axis=1) * cell, expected, rtol=1e-9)


# ---- finite elements


def test_stored_results_of_another_scene_are_refused_for_all_to_see(monkeypatch, tmp_path):
    def read(case, scene):
        raise ResultFileError(f"{case}: computed for another scene")

    monkeypatch.setattr(store, "DATA", tmp_path)
    (tmp_path / "finite_elements_worn.nc").write_bytes(b"x")
    monkeypatch.setattr(store, "read", read)
    cases = finite_elements.read_cases(sw.load_scene(store.SCENE), ("line",), NoProgress())
    states = {case.name: case.refusal for case in cases}
    assert states["worn"] == "worn: computed for another scene"
    assert states["unworn"] == "not stored"
    section = finite_elements.build(PROBLEMS, True, NoProgress())
    assert "REFUSED, computed for another scene: worn" in " ".join(section.found)
    assert 'role="alert"' in section.html
    assert "Refused: worn: computed for another scene" in section.html
    assert section.datasets["rows"].sizes["row"] == 0


def test_the_hash_is_that_of_the_scene(monkeypatch, tmp_path):
    scene = sw.load_scene(store.SCENE)
    monkeypatch.setattr(store, "DATA", tmp_path)
    small = scene.replace({"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.harmonics": 3})
    store.store("unworn", sw.loaded_contact(small.replace({"wear": None}), [0.0]), 1.0)
    with pytest.raises(ResultFileError, match="computed for another scene"):
        store.read("unworn", scene)


def test_agreement_counts_pairs_that_bear_load():
    rows = [
        store.Row("load_share", "roll +0.000", 0.9, 0.88, "1"),
        store.Row("load_share", "roll +1.000", 0.05, 0.02, "1"),
        store.Row("contact_pressure_max", "roll +0.000", 800.0, 820.0, "MPa"),
        store.Row("contact_pressure_max", "roll +1.000", 300.0, 200.0, "MPa"),
        store.Row("transmission_error_loaded, mean", "cycle", -10.0, -10.2, "arcsec"),
    ]
    found = finite_elements.summary(rows)
    assert found["contact_pressure_max"].farthest.where == "roll +0.000"
    assert found["contact_pressure_max"].apart == pytest.approx(-20.0 / 820.0)
    assert found["load_share"].apart == pytest.approx(0.02)
    assert found["load_share"].limit == store.LIMITS["load_share"]
    assert found["transmission_error_loaded, mean"].limit == store.LIMITS["transmission_error"]


@pytest.mark.parametrize(
    ("core", "reference", "limited"), [(3e-4, -3e-5, False), (-8.9, -8.97, True), (3e-4, 2.0, True)]
)
def test_a_transmission_error_of_nothing_has_no_relative_limit(core, reference, limited):
    row = store.Row("transmission_error_unloaded", "position 0.000", core, reference, "arcsec")
    found = finite_elements.summary([row])["transmission_error_unloaded"]
    assert (found.limit is not None) is limited


# ---- peers


def test_peers_are_told_from_the_benchmark_and_missing_ones_named():
    row = {"case": "elliptic", "points": [64, 64], "variant": "nested", "ms": 2.0, "field_error": 5e-7, "ratio": None}
    report = {
        "target_field_error": 1e-6,
        "missing": {"aspher": "No module named 'aspher'"},
        "versions": {"semiwear": "0.2.0"},
        "rows": [row | {"code": "semiwear"}, row | {"code": "tamaas", "ms": 90.0, "ratio": 45.0}],
    }
    section = peers.from_report(report)
    text = " ".join(section.found)
    assert "tamaas takes 45" in text
    assert "Not installed, and so not compared: aspher." in text
    alone = peers.from_report(report | {"rows": report["rows"][:1]})
    assert "nothing to compare with" in " ".join(alone.found)


def test_figures_of_a_run_are_those_at_a_depth():
    steps = np.arange(3)
    history = xr.Dataset(
        {
            "wear_depth_control_point": ("wear_step", [0.0, 30.0, 60.0]),
            "root_stress_max": (("wear_step", "body"), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]),
            "transmission_error_mean": ("wear_step", [-1.0, -5.0, -9.0]),
            "transmission_error_amplitude": ("wear_step", [1.0, 2.0, 3.0]),
            "wear_depth_max_root": ("wear_step", [0.0, 31.0, 62.0]),
            "wear_depth_max_addendum": ("wear_step", [0.0, 20.0, 40.0]),
        },
        {"body": ["pinion", "gear"]},
    )
    loaded = np.array([[-1.0, -2.0], [-4.0, -6.0], [-8.0, -10.0]])
    cycle = xr.Dataset(
        {
            "transmission_error_loaded": (("wear_step", "mesh_position"), loaded),
            "transmission_error_unloaded": (("wear_step", "mesh_position"), np.outer(steps, [-2.0, -3.0])),
        }
    )
    figures = figures_of(xr.DataTree.from_dict({"/history": history, "/mesh_cycle": cycle}), 45.0)
    assert figures["gear root stress"] == pytest.approx(5.0)
    assert figures["mean transmission error"] == pytest.approx(-7.0)
    # what is left without the rigid part: (-2, -3) after 30 um, (-4, -4) after 60
    assert figures["mean transmission error without the rigid part of wear"] == pytest.approx(-3.25)
    assert figures["amplitude of the transmission error without the rigid part of wear"] == pytest.approx(0.5)
    assert set(figures) == set(FIGURES_OF_THE_PAPER)


def test_what_the_step_size_explains_is_told_grid_by_grid():
    schemes = dataset(
        {"scheme": ["explicit, 12 steps (the paper's)", "implicit, 48 steps"], "slices": [31, 61]},
        {"root": ([[90.0, 100.0], [60.0, 60.0]], "um", "greatest wear at the root")},
    )
    told = explained(schemes, {"at_60_um": {"max_wear_root_um": 120.0}})
    assert "50 % of the way" in told
    assert "67 % of the way" in told
    schemes["root"][0] = np.nan
    assert "do not reach" in explained(schemes, {"at_60_um": {"max_wear_root_um": 120.0}})

import base64
import gzip
import hashlib
import json
import re
import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest

from semiwear import plot
from semiwear.errors import MissingExtraError, SemiwearError
from semiwear.references import load_reference, load_statements, reference_names
from semiwear.report import write_report
from semiwear.report.comparison import Verdict, compare
from semiwear.report.markup import figure_text
from semiwear.report.measures import MEASURES
from semiwear.report.pictures import PICTURES
from semiwear.report.trends import LEVEL_SHARE, levels, rises
from tests.strategies.results import SCENE, changed, of_one_state, synthetic_tree, without

PAPER, STATED = load_reference("seed_paper"), load_statements("seed_paper")
NO_REFERENCE = SCENE.replace('reference = "seed_paper"\n', "")


def line_tree(wear_steps):
    """A result without what fidelity `patch` adds."""
    tree = synthetic_tree(wear_steps)
    for group in ("flank", "history"):
        names = ["contact_pattern", "subsurface_stress_max", "subsurface_stress_depth"]
        tree[group] = type(tree)(tree[group].to_dataset().drop_vars(names, errors="ignore"))
    return tree


@pytest.fixture(scope="module")
def tree():
    return synthetic_tree()


@pytest.fixture(scope="module")
def page(tree, tmp_path_factory):
    """A page whose pictures are made and not turned into pixels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)
        return write_report(tree, tmp_path_factory.mktemp("report") / "worn.html").read_text(encoding="utf-8")


def verdicts(tree, scene=None):
    """Verdict and texts by (picture, first words of the statement)."""
    scene = {
        "wear": {"coefficient_mm2_per_N": 1e-13},
        "operation": {"pinion_torque_Nm": 1600},
        **(scene or {}),
    }
    return {entry.statement: entry for entry in compare("seed_paper", tree, scene).statements}


def plain(text):
    """A page without scripts and pictures, whose letters may spell anything."""
    return re.sub(r"data:image[^\"]*", "", re.sub("<script.*?</script>", "", text, flags=re.S))


def one(found, words):
    (entry,) = [entry for statement, entry in found.items() if words in statement]
    return entry


# ---------------------------------------------------------------------- pictures


@pytest.mark.slow
@pytest.mark.parametrize("name", plot.__all__)
@pytest.mark.parametrize("wear_steps", [1, 2, 13])
def test_every_picture_is_drawn(name, wear_steps):
    drawn = getattr(plot, name)(synthetic_tree(wear_steps, profiles=9, faces=7))
    panels = drawn if isinstance(drawn, tuple) else (drawn,)
    for panel in panels:
        assert panel.get_xlabel() and panel.get_ylabel()
        panel.figure.canvas.draw()


@pytest.mark.parametrize("name", plot.__all__)
def test_every_picture_takes_axes_and_leaves_the_users_settings(name, tree):
    picture = next(picture for picture in PICTURES if picture.name == name)
    before = dict(matplotlib.rcParams)
    solid = {"projection": "3d"} if name == "wear_surface" else None
    figure, axes = plt.subplots(picture.panels, 1, squeeze=False, subplot_kw=solid)
    given = axes[0, 0] if picture.panels == 1 else axes[:, 0]
    drawn = getattr(plot, name)(tree, ax=given)
    assert (drawn[0] if isinstance(drawn, tuple) else drawn).figure is figure
    assert dict(matplotlib.rcParams) == before


def test_every_picture_of_plot_is_in_the_report():
    assert sorted(picture.name for picture in PICTURES) == sorted(plot.__all__)
    assert {statement["picture"] for statement in STATED["statement"]} <= set(plot.__all__)


def test_contact_patterns_of_one_result_share_their_colours(tree):
    limits = set()
    for wear_step in (0, -1):
        (mesh, *_) = plot.contact_pattern(tree, wear_step=wear_step).collections
        limits.add(mesh.get_clim())
    assert limits == {(0.0, tree["engagement"]["contact_pressure_max"].values.max())}


@pytest.mark.slow
def test_what_only_some_results_have_is_left_out_without_a_word(tmp_path, unseen):
    text = write_report(line_tree(3), tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Contact pattern" not in text and "contact_pattern" not in text and "below the surface" not in text
    with pytest.raises(SemiwearError, match="/flank/contact_pattern"):
        plot.contact_pattern(line_tree(3))


def test_what_patches_add_is_shown(page):
    tile = re.search(r"<li><span>Stress below the surface</span>(.*?)</li>", page)
    assert tile and ">600 MPa<" in tile[1] and "0.180 mm deep; 480 MPa unworn" in tile[1]
    assert "subsurface stress max" in page[page.index("Every wear step") :]
    assert 'alt="Contact pattern.' in page


def described(tree, name):
    (picture,) = [picture for picture in PICTURES if picture.name == name]
    return picture.describe(tree)


def test_texts_of_pictures_tell_what_their_curves_show(tree):
    """An edge that alone bears presses hardest: it is told as such, and the greatest value is that of the curve."""
    copy = tree.copy(deep=True)
    last = copy["engagement"].to_dataset().isel(wear_step=-1)
    roll, pressure = last["roll_position"].values, last["contact_pressure_max"].values.copy()
    alone = int(np.argmax(pressure)) - 3
    for name, value in (("max", 4212.0), ("on_edge", 1), ("max_edge", 4212.0)):
        copy["engagement"][f"contact_pressure_{name}"].values[-1, alone] = value
    text = described(copy, "contact_pressure_over_engagement")
    place = f"at roll position {roll[np.argmax(pressure)]:+.2f}".replace("-", "−")
    assert f"away from borders at the last wear step: {figure_text(pressure.max())} MPa {place}" in text
    assert f"at an edge 4212 MPa at roll position {roll[alone]:+.2f}".replace("-", "−") in text
    curves = plot.contact_pressure_over_engagement(copy).lines
    assert max(np.nanmax(line.get_ydata()) for line in curves if line.get_ls() == "-") < 4212.0


def test_the_text_on_sliding_names_both_bodies(tree):
    sliding = tree["engagement"].sliding_distance.isel(wear_step=-1).max("roll_position")
    text = described(tree, "sliding_along_path")
    for body in ("pinion", "gear"):
        assert f"{body} {figure_text(float(sliding.sel(body=body)))} mm at roll position" in text


def test_wrong_number_of_axes_is_refused(tree):
    with pytest.raises(SemiwearError, match="2 panels"):
        plot.load_share(tree, ax=plt.subplots()[1])


def test_a_picture_says_what_it_lacks(tree):
    with pytest.raises(SemiwearError, match="/flank/wear_depth"):
        plot.wear_map(without(tree, "flank"))


def test_missing_matplotlib_names_the_extra(tree, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"semiwear\[plot\]"):
        plot.wear_map(tree)
    with pytest.raises(MissingExtraError):
        write_report(tree, "never.html")


# ---------------------------------------------------------------------- page


def test_the_page_needs_nothing_but_itself(page):
    assert not re.search(r"""(src|href|url)\s*[=(]\s*["']?(https?:)?//""", page)
    assert not re.search(r"<script[^>]*src", page) and "<link" not in page and "@import" not in page
    sources = re.findall(r'src="([^"]{0,30})', page)
    assert len(sources) >= len(PICTURES) and all(src.startswith("data:image/png;base64,") for src in sources)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)', page)[1]
    assert "default-src 'none'" in policy and "script-src &#x27;unsafe" not in policy
    links = re.findall('href="([^"]*)"', page)
    assert links and all(re.search(f'<section id="{link[1:]}">', page) for link in links)


def test_the_page_runs_no_script_but_its_own(page):
    policy = re.search(r'Content-Security-Policy" content="([^"]*)', page)[1]
    (script,) = re.findall("<script>(.*?)</script>", page, flags=re.S)
    library = gzip.decompress(base64.b64decode(re.search('id="turning-library">([^<]*)', page)[1]))
    for text in (script.encode(), library):
        assert base64.b64encode(hashlib.sha256(text).digest()).decode() in policy
    assert "unsafe-eval" not in policy
    told = json.loads(re.search('id="turning-told">(.*?)</script>', page)[1])
    assert [body["name"] for body in told["bodies"]] == ["pinion", "gear"]


@pytest.mark.slow
def test_a_page_with_its_pictures_is_light(tree, tmp_path):
    text = write_report(tree, tmp_path / "worn.html").read_text(encoding="utf-8")
    pictures = re.findall(r'<img [^>]*?src="data:image/png;base64,([^"]*)"', text)
    assert len(pictures) >= len(PICTURES)
    assert all(base64.b64decode(picture).startswith(b"\x89PNG") for picture in pictures)
    assert len(text.encode()) < 6e6


def test_what_came_out_stands_before_what_went_in(page):
    places = [page.index(f"<h2>{name}</h2>") for name in ("Result", "Worn flanks", "Over the life", "Inputs")]
    assert places == sorted(places)
    first = page[: page.index("<h2>Worn flanks</h2>")]
    for text in ("Contact ratio under load", "Life until 50 µm", "Advice: tip edges in contact"):
        assert text in first
    assert "DISAGREE" not in re.sub("<details>.*?</details>", "", page, flags=re.S)
    assert page.count("<details>") >= 2 and re.search(r"<summary>Of \d+ statements of .* agree", page)


def test_every_picture_has_a_text(page):
    for alt in re.findall(r"<img [^>]*?alt=\"([^\"]*)\"", page):
        assert len(alt) > 40
    apart = [page.partition(f"<h2>{name}</h2>")[2] for name in ("What effects add", "What ends the life")]
    others = sum(rest.partition("</section>")[0].count("<figcaption>") for rest in apart)
    both = sum(picture.of_body for picture in PICTURES)  # both bodies wear
    assert plain(page).count("<figcaption>") - others == len(PICTURES) + both + 1  # and the one that turns


def test_the_page_shows_inputs_physics_steps_and_diagnostics(page):
    for words in (
        "[gear_pair]",
        "[material.pinion]",
        "module_mm",
        "wear: swept line, implicit steps",
        "Every wear step",
        "load balance residual",
        "compliance",
        "Archard 1953",
    ):
        assert words in page
    steps = page[page.index("<h2>Every wear step") : page.index("<h2>What ran")]
    assert [int(step) for step in re.findall(r'<th scope="col">(\d+)</th>', steps)] == list(range(13))


@pytest.mark.slow
def test_text_of_the_scene_is_escaped(tmp_path, unseen):
    scene = NO_REFERENCE.replace("face_gear_25x160", "<script>alert(1)</script>")
    text = write_report(synthetic_tree(2, scene_toml=scene), tmp_path / "r.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text


@pytest.mark.slow
def test_no_paper_without_a_reference(tmp_path, unseen):
    path = write_report(synthetic_tree(3, scene_toml=NO_REFERENCE), tmp_path / "r.html")
    text = path.read_text(encoding="utf-8")
    words = plain(text.split("</style>")[1])
    assert not re.search(r"paper\b|AGREE|seed", words)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["", "this is = no toml = at all", 'reference = "another"'])
def test_odd_scenes_give_a_page(tmp_path, scene, unseen):
    text = write_report(synthetic_tree(2, scene_toml=scene), tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Against the paper" not in text


def test_one_wear_step_gives_a_page_without_curves_over_the_life(tmp_path, unseen):
    text = write_report(synthetic_tree(1), tmp_path / "r.html").read_text(encoding="utf-8")
    assert "NOT COMPARED" in text and "DISAGREE" not in text
    assert "Left out" in text


def test_loaded_contact_alone_gives_a_page(tmp_path, tree, unseen):
    for group in ("flank", "history", "diagnostics"):
        tree = without(tree, group)
    text = write_report(tree, tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Transmission error over the mesh cycle" in text


@pytest.mark.slow
def test_a_failing_report_leaves_the_old_page(tmp_path, tree, monkeypatch, unseen):
    path = tmp_path / "r.html"
    path.write_text("old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        write_report(tree, path)
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


# ---------------------------------------------------------------------- verdicts


@pytest.fixture(scope="module")
def unchanged(tree):
    return verdicts(tree)


def test_a_tree_shaped_like_the_paper_agrees(unchanged):
    found = unchanged
    agreeing = [entry for entry in found.values() if entry.verdict is Verdict.AGREE]
    assert len(found) == len(STATED["statement"]) and len(agreeing) >= 20
    assert all(entry.why == "" for entry in agreeing)
    assert all(entry.why for entry in found.values() if entry.verdict is Verdict.DISAGREE)


REVERSED = [
    ("history/load_share_max", "greatest load share rises"),
    ("history/root_stress_max", "gear's root stress rises"),
    ("history/root_stress_max", "pinion's root stress rises"),
    ("history/contact_pressure_root", "Contact stress at the root falls"),
    ("history/contact_pressure_addendum", "Contact stress at the addendum falls"),
    ("history/contact_pressure_pitch", "Contact stress at the pitch cone"),
    ("history/transmission_error_mean", "size of the mean"),
    ("history/transmission_error_amplitude", "amplitude of the loaded transmission error rises"),
    ("history/transmission_error_mean", "Mean −12.83"),
    ("history/transmission_error_amplitude", "Amplitude 4.31"),
]


@pytest.mark.parametrize(
    ("path", "change", "words"),
    [
        *((path, lambda v: v[::-1].copy(), words) for path, words in REVERSED),
        ("history/root_stress_max", lambda v: v[:, ::-1].copy(), "always above the gear's"),
        ("history/root_stress_max", lambda v: 1.2 * v, "Gear 130.12"),
        ("history/root_stress_max", lambda v: 0.8 * v, "Pinion 131.59"),
        ("history/wear_depth_max_addendum", lambda v: 10 * v, "Wear is deepest at the tooth root"),
        ("engagement/load_share", lambda v: np.roll(v, 6, axis=1), "load share is greatest near the middle"),
        ("engagement/root_stress", lambda v: np.roll(v, 6, axis=1), "Root stress is greatest when"),
        ("engagement/sliding_distance", lambda v: v + 0.2, "Relative sliding is close to zero"),
        ("flank/wear_depth", lambda v: v.max() - v, "Along the tooth height"),
        ("flank/wear_depth", lambda v: v[..., ::-1].copy() ** 2, "Along the tooth width"),
    ],
)
def test_changed_data_disagree(tree, unchanged, path, change, words):
    assert one(unchanged, words).verdict is Verdict.AGREE
    entry = one(verdicts(changed(tree, path, change)), words)
    assert entry.verdict is Verdict.DISAGREE and entry.why


@pytest.mark.parametrize(
    ("name", "words"),
    [("root", "112.48"), ("addendum", "20.61")],
)
def test_wear_values_are_compared_at_the_papers_depth(tree, name, words):
    published = PAPER["at_60_um"][f"max_wear_{name}_um"]

    def scaled(factor):
        return changed(tree, f"history/wear_depth_max_{name}", lambda v: v / v[-1] * published * factor)

    assert one(verdicts(scaled(1.0)), words).verdict is Verdict.AGREE
    assert one(verdicts(scaled(1.24)), words).verdict is Verdict.AGREE
    assert one(verdicts(scaled(1.26)), words).verdict is Verdict.DISAGREE


def test_meshes_with_the_papers_own_numbers_agree(tree, unchanged):
    paper_meshes = np.array([0.0, *PAPER["wear"]["engagements_1e10"]]) * 1e10
    copy = tree.copy(deep=True)
    history = copy["history"].to_dataset().assign_coords(meshes=("wear_step", paper_meshes))
    copy["history"] = type(copy)(history)
    found = verdicts(copy)
    for words in ("Each further 5", "Course of the engagements", "73.9·10¹⁰"):
        assert one(found, words).verdict is Verdict.AGREE
    assert "2 of 11 steps" in one(found, "Each further 5").ours
    factor = one(unchanged, "73.9·10¹⁰")
    assert factor.verdict is Verdict.DISAGREE and "a factor of 72" in factor.ours


def test_wear_that_falls_short_is_not_compared():
    short = verdicts(synthetic_tree(10))
    entry = one(short, "112.48")
    assert entry.verdict is Verdict.NOT_COMPARED and "45 µm" in entry.ours
    assert one(short, "gear's root stress rises").verdict is Verdict.AGREE


def test_wear_of_the_pinion_alone_is_not_compared(tree):
    """The gear's flank is unworn then: the paper's shares of its wear would be divided by zero."""
    found = verdicts(changed(tree, "flank/wear_depth", np.zeros_like), {"wear": {"worn_bodies": ["pinion"]}})
    for words in ("112.48", "pitch cone is close to zero", "across the face"):
        matching = [entry for statement, entry in found.items() if words in statement]
        assert all(entry.verdict is Verdict.NOT_COMPARED and "the pinion alone" in entry.ours for entry in matching)
    assert one(found, "112.48").verdict is Verdict.NOT_COMPARED
    assert one(found, "Relative sliding is close to zero").verdict is not Verdict.NOT_COMPARED


def test_names_in_statements_have_one_meaning():
    assert not set(MEASURES) & {*PAPER, *STATED}
    assert PAPER["wear"]["control_depth_um"][7] == 40.0  # from where the paper's courses turn; the statements name it
    assert len(PAPER["wear"]["control_depth_um"]) == len(PAPER["wear"]["engagements_1e10"]) == 12


def test_sentences_on_what_a_result_lacks_are_left_out(tree):
    high = changed(tree, "history/root_stress_max", lambda v: 1.3 * v)
    entry = one(verdicts(high), "Gear 130.12")
    assert "would bring the published value" in entry.why and "nan" not in entry.why
    entry = one(verdicts(high, {"operation": {}}), "Gear 130.12")
    assert entry.verdict is Verdict.DISAGREE and "would bring" not in entry.why and "neither torque" in entry.why


def test_absent_variables_are_not_compared(tree):
    lacking = without(tree, "history", "root_stress_max")
    assert one(verdicts(lacking), "Gear 130.12").verdict is Verdict.NOT_COMPARED


# ---------------------------------------------------------------------- small pieces


def test_trends_name_the_reversal():
    trend = rises(np.array([1.0, 2.0, 1.5, 3.0]))
    assert not trend.holds and "from 2 at step 1 to 1.500 at step 2" in trend.text
    assert rises(np.array([1.0, 2.0, 1.95, 3.0])).holds
    assert not rises(np.ones(4)).holds
    slope = np.linspace(0, 1, 10)
    assert LEVEL_SHARE < 1 / 3 and not levels(slope, slope).holds


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (13.0, "13"),
        (0.78, "0.7800"),
        (-12.83, "−12.83"),
        (1.0221e10, "1.02·10¹⁰"),
        (3e-9, "3.00·10⁻⁹"),
        (9.9996e-16, "1.00·10⁻¹⁵"),
        (-9.99996e7, "−1.00·10⁸"),
        (99.9999, "100.0"),
        (999999.9, "1.00·10⁶"),
        (0.0012345, "0.001234"),
    ],
)
def test_figures(value, text):
    assert figure_text(value) == text


def test_references():
    assert {"seed_paper", "block_on_ring"} <= set(reference_names())
    with pytest.raises(SemiwearError, match="seed_paper"):
        load_reference("nothing")


def test_loaded_contact_without_meshes_is_drawn(tree):
    copy = of_one_state(tree)
    panel = plot.transmission_error_curves(copy)
    assert [text.get_text() for text in panel.texts] == ["wear step 0"]
    plot.sliding_along_path(copy)
    plot.contact_pressure_over_engagement(copy)

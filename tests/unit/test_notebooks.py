"""In notebooks: scenes, plans and screenings show themselves, pictures take axes, and the tutorial runs."""

import inspect
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

import semiwear as sw
from semiwear import plot
from semiwear.plot import against, sweeps
from semiwear.screen import QUANTITIES, ScreenedEffect, Screening
from tests.scenes import TINY

NOTEBOOK = Path(__file__).parents[2] / "docs" / "notebooks" / "spur_pair.ipynb"


class Balanced(HTMLParser):
    """Checks that every tag is closed in order, and keeps the text."""

    def __init__(self):
        super().__init__()
        self.open, self.text = [], []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def shown(thing):
    reader = Balanced()
    reader.feed(thing._repr_html_())
    assert not reader.open
    return " ".join(reader.text)


def test_scenes_show_every_field_and_escape_their_text():
    scene = sw.load_scene("spur_fzg_c").replace({"title": "<b>& co", "effects.friction": {}})
    text = shown(scene)
    assert "<b>& co" in text and "&lt;b&gt;&amp; co" in scene._repr_html_()
    for word in ("pinion_teeth", "friction.coefficient", "youngs_modulus_MPa", "roll_positions", "spur gears 16/24"):
        assert word in text


def test_plans_and_screenings_show_what_they_print():
    scene = sw.load_scene("spur_fzg_c").replace(TINY)
    plan = sw.plan(scene)
    assert all(choice.why in shown(plan) for choice in plan.choices)
    changes = dict.fromkeys(QUANTITIES, 0.031)
    rows = (
        ScreenedEffect("friction", False, changes, 1.2),
        ScreenedEffect("lubrication", False, {}, None, "<needs>"),
    )
    found = Screening(scene, 0.02, dict.fromkeys(QUANTITIES, 1.0), 0.1, rows)
    text = shown(found)
    assert all(row.effect in text for row in found.rows) and "<needs>" in text and "called for at 2 %" in text


PICTURES = [getattr(plot, name) for name in plot.__all__] + [
    plot.measured_wear, plot.sweep_curves, plot.sweep_map, plot.sweep_samples,
    against.wear_difference, against.pressure_of_both, sweeps.sweep_map,
]  # fmt: skip


@pytest.mark.parametrize("picture", PICTURES, ids=lambda picture: picture.__name__)
def test_every_picture_takes_axes_and_returns_them(picture):
    signature = inspect.signature(picture)
    assert signature.parameters["ax"].default is None
    assert re.search(r"\bAxes\b", str(signature.return_annotation))


@pytest.mark.slow
def test_the_notebook_runs(tmp_path, monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)  # the kernel's own shows pictures in the notebook
    nbclient = pytest.importorskip("nbclient", reason="extra notebook: it is run by nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel", reason="extra notebook: it is run by ipykernel")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") for cell in notebook.cells)  # outputs are made where it is read
    done = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3",
                                   resources={"metadata": {"path": str(tmp_path)}}).execute()  # fmt: skip
    outputs = [output for cell in done.cells for output in cell.get("outputs", [])]
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    assert {"text/html", "image/png"} <= kinds
    assert (tmp_path / "worn.vtu").exists()

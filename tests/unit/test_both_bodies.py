"""Pinion and gear are shown alike: defaults, control point, table, pictures and words of a result."""

import copy
import re

import numpy as np
import pytest

import semiwear as sw
from semiwear import plot
from semiwear.commands.wear_table import wear_table
from semiwear.errors import SemiwearError
from semiwear.report import write_report
from semiwear.results.wearing import control_place, pitch_name, worn_bodies
from semiwear.scene import scene_from_dict
from tests.scenes import problems_of
from tests.strategies.results import SCENE, synthetic_tree

BODIES = ("pinion", "gear")
CYLINDRICAL = SCENE.replace('type = "face_gear"', 'type = "cylindrical"')
POINT = """
[wear.control_point]
face_mm = 520
height_mm = 2.0
body = "pinion"
"""


def tree_of(worn, scene_toml=CYLINDRICAL):
    """A result in which only these bodies wear."""
    scene_toml = scene_toml.replace("[wear]\n", f"[wear]\nworn_bodies = {list(worn)}\n".replace("'", '"'))
    tree = copy.deepcopy(synthetic_tree(3, profiles=21, faces=9, scene_toml=scene_toml))
    for index, body in enumerate(BODIES):
        if body not in worn:
            tree["flank/wear_depth"].values[:, index] = 0.0
            tree["history/wear_depth_max"].values[:, index] = 0.0
    return tree


def spur(**wear):
    """The shipped spur pair as nested mappings, its bodies left to their default."""
    data = sw.load_scene("spur_fzg_c").to_dict()
    del data["wear"]["worn_bodies"]
    data["wear"] |= wear
    return data


class TestDefault:
    def test_both_bodies_of_a_cylindrical_pair_wear(self):
        scene = scene_from_dict(spur())
        assert scene.wear.worn_bodies == BODIES
        assert scene == sw.load_scene("spur_fzg_c") and scene.sha256 == sw.load_scene("spur_fzg_c").sha256

    def test_the_gear_of_a_face_gear_pair_wears(self):
        data = sw.load_scene("face_gear_25x160").to_dict()
        del data["wear"]["worn_bodies"]
        assert scene_from_dict(data).wear.worn_bodies == ("gear",)

    @pytest.mark.parametrize("body", BODIES)
    def test_a_body_without_a_coefficient_does_not_wear(self, body):
        assert scene_from_dict(spur(coefficient_mm2_per_N={body: 1e-13})).wear.worn_bodies == (body,)

    def test_it_fits_the_mapping(self):
        data = spur() | {"numerics": {"fidelity": "patch", "wear_mapping": "marched"}}
        assert scene_from_dict(data).wear.worn_bodies == ("gear",)

    def test_it_follows_a_change(self):
        scene = scene_from_dict(spur())
        changed = scene.replace({"wear.coefficient_mm2_per_N": {"gear": 1e-13}})
        assert changed.wear.worn_bodies == ("gear",)
        assert sw.load_scene("spur_fzg_c").replace({"wear.worn_bodies": ["gear"]}).wear.worn_bodies == ("gear",)

    def test_the_plan_says_what_is_a_default(self):
        assert "worn_bodies = pinion, gear (a default" in " ".join(str(sw.plan(scene_from_dict(spur()))).split())
        assert "a default" not in str(sw.plan(sw.load_scene("spur_fzg_c"))).partition("end of the run")[0]


class TestControlPoint:
    @pytest.mark.parametrize(("worn", "body"), [(BODIES, "gear"), (("gear",), "gear"), (("pinion",), "pinion")])
    def test_it_lies_on_the_gear_unless_the_pinion_alone_wears(self, worn, body):
        data = spur(worn_bodies=list(worn), control_point={"face_mm": 0.0, "height_mm": 1.0})
        assert scene_from_dict(data).wear.watched_body == body

    @pytest.mark.parametrize("name", ["spur_fzg_c", "face_gear_25x160"])
    @pytest.mark.parametrize("height", [-7.0, 6.3])
    def test_it_lies_on_the_active_flank_of_the_pinion(self, name, height):
        point = {"height_mm": height, "body": "pinion", "face_mm": 0.0}
        if name.startswith("face"):
            point = {"height_mm": height, "body": "pinion", "radius_mm": 508.0}
        change = {"wear.worn_bodies": list(BODIES), "wear.control_point": point}
        ((field, problem),) = problems_of(sw.load_scene(name).replace, change).items()
        assert field == "wear.control_point.height_mm" and "pinion" in problem.allowed + problem.fix
        low, high = map(float, re.findall(r"-?\d+\.?\d*", problem.allowed)[:2])
        for inside in (low, high):
            point = point | {"height_mm": inside}
            changes = {"wear.worn_bodies": list(BODIES), "wear.control_point": point}
            assert sw.load_scene(name).replace(changes).wear.watched_body == "pinion"


class TestWorn:
    @pytest.mark.parametrize("worn", [("pinion",), ("gear",), BODIES])
    def test_the_table_shows_every_body_that_wears(self, worn):
        tree = tree_of(worn)
        greatest = [float(tree["flank/wear_depth"].sel(body=body)[-1].max()) for body in worn]
        head, *rows = wear_table(tree).splitlines()
        assert ("wear p/g [um]" if len(worn) > 1 else f"{worn[0]} wear [um]") in head
        assert "/".join(f"{depth:.1f}" for depth in greatest) in rows[-1].split()
        assert f"{float(tree['history/wear_depth_max_pinion_root'][-1]):.1f}" in rows[-1] or "pinion" not in worn

    @pytest.mark.slow
    @pytest.mark.parametrize("worn", [("pinion",), ("gear",), BODIES])
    def test_every_body_has_its_pictures_and_key_number(self, tmp_path, worn, unseen):
        text = write_report(tree_of(worn), tmp_path / "r.html").read_text(encoding="utf-8")
        for body in BODIES:
            for words in ("Wear of the {}'s flank", "Sections through the wear of the {}", "Worn flank of the {}"):
                assert (f"<h3>{words.format(body)}</h3>".replace("'", "&#x27;") in text) == (body in worn)
            assert (f"<span>Greatest wear, {body}</span>" in text) == (body in worn)

    @pytest.mark.parametrize("name", ["wear_map", "wear_surface", "wear_profiles"])
    def test_pictures_take_a_body(self, name):
        tree = tree_of(BODIES)
        titles = []
        for body in BODIES:
            drawn = getattr(plot, name)(tree, body=body)
            panel = drawn[0] if isinstance(drawn, tuple) else drawn
            titles.append(panel.get_title() + panel.get_title(loc="left"))
            assert body in titles[-1].lower()
        with pytest.raises(SemiwearError, match="wheel"):
            getattr(plot, name)(tree, body="wheel")

    def test_the_map_is_of_the_body_that_wears(self):
        mesh = plot.wear_map(tree_of(("pinion",))).collections[0]
        assert mesh.get_array().max() > 1.0

    def test_wear_of_two_results_is_compared_on_the_pinion(self):
        tree, other = tree_of(("pinion",)), tree_of(("pinion",))
        other["flank/wear_depth"].values[:, 0] *= 0.5
        assert plot.against.wear_difference(tree, other).collections[0].get_array().max() > 1.0


class TestMarks:
    def names(self, tree, body="pinion"):
        return [text.get_text() for text in plot.wear_map(tree, body=body).texts]

    def test_every_mark_of_a_map_is_named(self):
        tree = tree_of(BODIES, CYLINDRICAL + POINT)
        assert control_place(tree) == ("pinion", 520.0, 2.0)
        assert self.names(tree) == ["pitch cylinder's band", "greatest wear", "control point"]
        assert self.names(tree, "gear") == ["pitch cylinder's band", "greatest wear"]

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("kind", "name"),
        [("face_gear", "pitch cone"), ("cylindrical", "pitch cylinder"), ("flank_points", "pitch surface")],
    )
    def test_pitch_surfaces_have_their_own_names(self, tmp_path, kind, name, unseen):
        scene = SCENE.replace('reference = "seed_paper"\n', "").replace('"face_gear"', f'"{kind}"')
        tree = tree_of(BODIES, scene)
        assert pitch_name(tree) == name and worn_bodies(tree) == BODIES
        text = write_report(tree, tmp_path / "r.html").read_text(encoding="utf-8").split("</style>")[1]
        assert name in text and ("pitch cone" in text) == (kind == "face_gear")

    def test_wear_is_drawn_into_the_tooth(self, monkeypatch):
        from mpl_toolkits.mplot3d import Axes3D

        drawn = []
        plain = Axes3D.plot_surface
        monkeypatch.setattr(Axes3D, "plot_surface", lambda *a, **k: drawn.append((a, k)) or plain(*a, **k))
        tree = tree_of(BODIES)
        axes = plot.wear_surface(tree)
        ((_, _, _, depth), options) = drawn[0]
        np.testing.assert_allclose(depth[:, :: (depth.shape[1] - 1) // 8], -tree["flank/wear_depth"].values[-1, 1])
        assert options["rstride"] == options["cstride"] == 1  # nodes left out look like the teeth of a comb
        assert "times as great" in axes.get_title() + axes.get_title(loc="left")


@pytest.mark.slow
def test_each_work_is_listed_once_and_none_of_solvers(tmp_path, unseen):
    """Archard's paper, Johnson's book and Litvin's are named by the physics and by quantities, in other words."""
    tree = tree_of(BODIES)
    tree.attrs["references"] = "Archard 1953, J. Appl. Phys. 24\nJohnson 1985, Contact Mechanics, ch. 4\nISO 21771"
    text = write_report(tree, tmp_path / "r.html").read_text(encoding="utf-8").partition("<h2>References</h2>")[2]
    works = re.findall("<li>(.*?)</li>", text)
    for work in ("Archard 1953", "Johnson 1985", "Litvin and Fuentes 2004", "ISO 21771"):
        assert sum(line.startswith(work) for line in works) == 1
    assert any("981-988" in line for line in works)  # as fully as known
    assert not any("Polonsky" in line for line in works)  # of a solver's residual, which no physics that ran names

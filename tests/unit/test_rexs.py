"""REXS files: the shipped spur pair by hand in XML, JSON and zip, what is left out, and what is refused."""

import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import semiwear as sw
from semiwear.cli import main

EXAMPLE = Path(__file__).parents[1] / "data" / "spur_fzg_c.rexs"
TEXT = EXAMPLE.read_text(encoding="utf-8")


def as_json():
    """The example in the JSON form of the standard."""
    model = ElementTree.fromstring(TEXT)

    def component(one):
        attributes = []
        for each in one.findall("attribute"):
            kind = "floating_point_array" if len(each) else "floating_point"
            value = [float(c.text) for c in each.iter("c")] if len(each) else each.text
            if kind == "floating_point":
                try:
                    value = float(value)
                except ValueError:
                    kind = "string"
            attributes.append({"id": each.get("id"), "unit": each.get("unit"), kind: value})
        return {"id": int(one.get("id")), "type": one.get("type"), "name": one.get("name"), "attributes": attributes}

    relations = [
        {
            "id": int(one.get("id")),
            "type": one.get("type"),
            "refs": [{"id": int(ref.get("id")), "role": ref.get("role")} for ref in one],
        }
        for one in model.iter("relation")
    ]
    cases = [
        {"id": 1, "components": [component(one) for one in case.findall("component")]}
        for case in model.iter("load_case")
    ]
    return json.dumps(
        {
            "model": {
                "version": model.get("version"),
                "relations": relations,
                "components": [component(one) for one in model.findall("components/component")],
                "load_spectrum": {"id": 1, "load_cases": cases},
            }
        }
    )


@pytest.mark.parametrize("form", ["xml", "json", "zip"])
def test_the_example_is_the_shipped_scene(form, tmp_path):
    path = EXAMPLE
    if form == "json":
        path = tmp_path / "pair.rexsj"
        path.write_text(as_json(), encoding="utf-8")
    elif form == "zip":
        path = tmp_path / "pair.rexsz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("model.rexs", TEXT)
    found = sw.read_rexs(path)
    shipped = sw.load_scene("spur_fzg_c")
    own, theirs = found.scene.to_dict(), shipped.to_dict()
    assert own["gear_pair"] == {
        key: pytest.approx(value, rel=1e-12) if isinstance(value, float) else value
        for key, value in theirs["gear_pair"].items()
    }
    assert own["material"] == theirs["material"]
    assert found.scene.operation.pinion_torque_Nm == 302.0
    # every attribute is either taken or told, but for places in space
    text = str(found)
    assert "cylindrical_gear 3 (pinion): arithmetic_average_roughness_flank = 0.4 mum" in found.left_out
    assert "material 11: density = 7.85 kg / dm^3" in found.left_out
    assert len(found.left_out) == 2 and all(line in text for line in found.left_out)
    assert "gear_pair.gear_rim_thickness_mm" in text


def changed(tmp_path, *pairs):
    text = TEXT
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path / "changed.rexs"
    path.write_text(text, encoding="utf-8")
    return path


GEARS = ('<ref id="3" role="gear_1" hint="cylindrical_gear"/><ref id="4" role="gear_2"',
         '<ref id="4" role="gear_1" hint="cylindrical_gear"/><ref id="3" role="gear_2"')  # fmt: skip


def test_the_gear_with_fewer_teeth_is_the_pinion(tmp_path):
    assert sw.read_rexs(changed(tmp_path, GEARS), pinion_torque_Nm=302.0).scene.gear_pair.pinion_teeth == 16


WITHOUT_SIZES = [
    (f'<attribute id="{name}" unit="mm">{value}</attribute>', "")
    for name, value in (
        ("center_distance", 91.5),
        ("tip_diameter", 82.4565),
        ("tip_diameter", 118.3647),
        ("root_diameter", 62.3853),
        ("root_diameter", 98.2935),
    )
]
"""Changes that leave out the sizes on which the helix angle has an influence."""


def helix(*angles):
    """Helix angles of pinion and gear in place of 0."""
    attribute = '<attribute id="helix_angle_reference_diameter" unit="deg">{}</attribute>'
    return [(attribute.format(0), attribute.format(angle)) for angle in angles]


def test_helical_teeth_have_a_hand(tmp_path):
    pair = sw.read_rexs(changed(tmp_path, *helix(-20, 20), *WITHOUT_SIZES)).scene.gear_pair
    assert (pair.helix_angle_deg, pair.hand) == (20.0, "left")
    with pytest.raises(sw.SceneError, match="opposite signs"):
        sw.read_rexs(changed(tmp_path, *helix(20, 20)))


def test_a_file_of_the_second_version_names_the_units_anew(tmp_path):
    """REXS 2.0 gives the elastic modulus in MPa."""
    units = [('unit="N / mm^2">206000', 'unit="MPa">206000'), ('version="1.4"', 'version="2.0"')]
    material = sw.read_rexs(changed(tmp_path, *units)).scene.material
    assert (material.pinion.youngs_modulus_MPa, material.gear.youngs_modulus_MPa) == (206000.0, 206000.0)


RING = [('<component id="4" type="cylindrical_gear" name="gear">', '<component id="4" type="ring_gear" name="ring">'),
        ('unit="mm">118.3647<', 'unit="mm">{sign}268<'), ('unit="mm">98.2935<', 'unit="mm">{sign}285.75<'),
        ('<attribute id="inner_diameter" unit="mm">68.04</attribute>', ""),
        ('unit="mm">82.4565<', 'unit="mm">99<'), ('unit="mm">62.3853<', 'unit="mm">78.75<'),
        ('unit="none">16<', 'unit="none">20<'), ('unit="mm">91.5<', 'unit="mm">{distance}<'),
        *[(f'unit="none">{shift}<', 'unit="none">0<') for shift in (0.1817, 0.1817, 0.1715, 0.1715)]]  # fmt: skip


@pytest.mark.parametrize("distance", ["92.25", "-92.25", None])
@pytest.mark.parametrize("teeth", ["61", "-61"])
@pytest.mark.parametrize("first", [False, True])
def test_a_ring_gear_has_negative_teeth_whichever_sign_a_file_gives_it(first, teeth, distance, tmp_path):
    ring = [('unit="none">24<', f'unit="none">{teeth}<'), *([GEARS] if first else [])]
    sign = "-" if teeth.startswith("-") else ""
    ring += [
        (old, new.format(distance=distance, sign=sign)) for old, new in RING if distance or "distance" not in new
    ]
    if distance is None:
        ring.append(('<attribute id="center_distance" unit="mm">91.5</attribute>', ""))
    found = sw.read_rexs(changed(tmp_path, *ring), pinion_torque_Nm=302.0)
    pair = found.scene.gear_pair
    assert (pair.pinion_teeth, pair.gear_teeth) == (20, -61)
    if distance is not None:
        assert pair.centre_distance_mm == 92.25
    assert pair.gear_rack_addendum_mm == pytest.approx(1.25 * 4.5) == pair.pinion_rack_addendum_mm
    (told,) = [value for field, value, _ in found.taken if field == "gear_pair.gear_teeth"]
    assert told == "-61"


def test_helical_teeth_of_a_ring_gear_have_the_hand_of_the_pinion(tmp_path):
    ring = [('unit="none">24<', 'unit="none">61<'), *(pair for pair in RING if 'unit="mm">' not in pair[0])]
    found = sw.read_rexs(changed(tmp_path, *WITHOUT_SIZES, *ring, *helix(12, 12)))
    pair = found.scene.gear_pair
    assert (pair.gear_teeth, pair.helix_angle_deg, pair.hand) == (-61, 12.0, "right")
    assert ("gear_pair.hand", "right", "cylindrical_gear 3 (pinion): helix_angle_reference_diameter") in found.taken


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        ([("</model>", "")], "damaged"),
        ([('version="1.4"', 'version="7.0"')], "REXS 7.0"),
        ([('type="cylindrical_stage" name="type C"', 'type="bevel_stage" name="type C"')], "other kinds of stages"),
        ([('<ref id="4" role="gear_2" hint="cylindrical_gear"/></relation>', "</relation>")], "1 gears"),
        ([('<ref id="11" role="referenced"', '<ref id="99" role="referenced"')], "components 99"),
        ([('unit="deg">20<', 'unit="rad">0.349<')], "'deg'"),
        ([('unit="none">16<', 'unit="none">sixteen<')], "found 'sixteen'; allowed: a finite number"),
        ([('unit="mm">4.5<', 'unit="mm">5<')], "5 and 4.5"),
        ([('unit="N m">-302<', 'unit="N m">nan<')], "torque"),
        ([('unit="mm">91.5<', 'unit="mm">80<')], "centre_distance_mm"),
        ([("<model", "<rexs"), ("</model>", "</rexs>")], "root is <rexs>"),
    ],
)
def test_what_is_damaged_or_contradicts_itself_is_refused(pairs, words, tmp_path):
    with pytest.raises(sw.SceneError, match=words):
        sw.read_rexs(changed(tmp_path, *pairs))


def test_what_is_no_file_of_that_kind_is_refused(tmp_path):
    with pytest.raises(sw.SceneError, match="no such file"):
        sw.read_rexs(tmp_path / "none.rexs")
    (tmp_path / "a.rexsj").write_text('{"model": {"version": "1.4"}}')
    with pytest.raises(sw.SceneError, match="components"):
        sw.read_rexs(tmp_path / "a.rexsj")
    with zipfile.ZipFile(tmp_path / "a.rexsz", "w") as archive:
        archive.writestr("readme.txt", "nothing")
    with pytest.raises(sw.SceneError, match="0 REXS models"):
        sw.read_rexs(tmp_path / "a.rexsz")
    with pytest.raises(sw.SceneError, match='"2"'):
        sw.read_rexs(EXAMPLE, stage="17")


def test_the_command_writes_a_scene_that_loads(tmp_path, capsys):
    target = tmp_path / "pair.toml"
    assert main(["rexs", str(EXAMPLE), "-o", str(target), "--set", "wear.coefficient_mm2_per_N=1e-13",
                 "--set", "wear.until.meshes=1e6", "--json"]) == 0  # fmt: skip
    end = json.loads(capsys.readouterr().out)
    assert end["command"] == "rexs" and len(end["left_out"]) == 2
    scene = sw.load_scene(target)
    assert scene.wear.until.meshes == 1e6 and scene.gear_pair.gear_teeth == 24

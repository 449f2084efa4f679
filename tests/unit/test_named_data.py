"""Named materials, wear coefficients and oils: sourced, never a default, kept with a scene; citations as BibTeX."""

import json
import re

import numpy as np
import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.plan.choices import physics_choices
from semiwear.references.citations import bibliography, bibtex, keys_of, titled
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_set, named_sets, oil_at
from semiwear.scene import EFFECTS, parse_scene
from semiwear.scene.kinds import KINDS
from semiwear.scene.rules import wear_coefficient, youngs_modulus
from tests.scenes import problems_of

ALL = [(kind, name) for kind in (MATERIALS, WEAR, OILS) for name in named_sets(kind)]


@pytest.mark.parametrize(("kind", "name"), ALL)
def test_every_set_has_a_source_and_numbers_that_a_scene_takes(kind, name):
    found = named_set(kind, name)
    assert found["source"] in bibliography() and found["place"]
    if kind == MATERIALS:
        assert youngs_modulus().apply("", found["youngs_modulus_MPa"])[1] is None
        low, high = found.get("youngs_modulus_range_MPa", [found["youngs_modulus_MPa"]] * 2)
        assert low <= found["youngs_modulus_MPa"] <= high
        assert found["conditions"]
    elif kind == WEAR:
        assert wear_coefficient().apply("", found["coefficient_mm2_per_N"])[1] is None
        low, high = found.get("range_mm2_per_N", [found["coefficient_mm2_per_N"]] * 2)
        assert low <= found["coefficient_mm2_per_N"] <= high
        assert found["of"] and found["against"] and found["conditions"] and found["rough"] in (True, False)
    else:
        assert all(value > 0.0 for value in oil_at(found, 60.0).values())


def test_wear_factors_are_turned_into_other_units_rightly():
    # in3 min/(lbf ft h): a volume over force and way, the way being ft/min times 60 min in an hour
    per_unit = 25.4**3 / (4.4482216 * 0.3048e3 * 60.0)
    given = {
        name: float(match.group(1))
        for name, found in named_sets(WEAR).items()
        if (match := re.search(r"([\d.]+e-10) in3", found["conditions"]))
    }
    assert len(given) == 6
    for name, factor in given.items():
        assert named_set(WEAR, name)["coefficient_mm2_per_N"] == pytest.approx(factor * per_unit, rel=0.01), name


def test_archard_numbers_are_divided_by_the_hardness():
    for name in ("steel_mild_dry", "steel_hard_dry", "steel_hard_boundary"):
        found = named_set(WEAR, name)
        number = float(re.search(r"K = ([\d.e-]+)", found["conditions"]).group(1))
        hardness = float(re.search(r"(\d+) MPa", found["conditions"]).group(1))
        assert found["coefficient_mm2_per_N"] == pytest.approx(number / hardness, rel=0.03), name


@pytest.mark.parametrize(("name", "grade"), [("FVA3", 100), ("mineral_320", 320), ("PAO_150", 150), ("PAO_320", 320)])
def test_oils_have_the_viscosity_of_their_grade(name, grade):
    oil = named_set(OILS, name)
    at_40 = oil_at(oil, 40.0)
    kinematic = 1e3 * at_40["viscosity_mPas"] / (oil["density_kg_per_m3"] * (1.0 + oil["expansion_per_K"] * 25.0))
    assert kinematic == pytest.approx(grade, rel=0.1)  # ISO 3448: within 10 %
    assert 10.0 < at_40["pressure_viscosity_per_GPa"] < 30.0
    assert oil_at(oil, 80.0)["viscosity_mPas"] < 0.4 * at_40["viscosity_mPas"]


def test_nothing_is_named_unless_the_scene_names_it(spur):
    assert spur.material.gear.data is None and spur.wear.data is None
    assert not [choice for choice in sw.plan(spur).choices if choice.slot.endswith("data")]
    with pytest.raises(sw.SceneError, match=r"wear.coefficient_mm2_per_N: missing.*semiwear materials"):
        spur.replace({"wear.coefficient_mm2_per_N": None})


def test_a_name_gives_the_numbers_and_stays_with_them(spur):
    named = spur.replace(
        {
            "material.gear": "POM",
            "wear.coefficient_mm2_per_N": None,
            "wear.worn_bodies": None,
            "wear.data": {"gear": "POM_homopolymer_on_steel"},
            "operation.pinion_speed_rpm": 1000.0,
            "effects.lubrication": {"data": "FVA3", "oil_temperature_C": 60.0},
        }
    )
    assert (named.material.gear.youngs_modulus_MPa, named.material.gear.poissons_ratio) == (3200.0, 0.35)
    assert named.material.gear.name == "POM" and named.material.pinion.data is None
    assert named.wear.coefficient("gear") == 1.21e-9 and named.wear.worn_bodies == ("gear",)
    oil = oil_at(named_set(OILS, "FVA3"), 60.0)
    assert named.effects.lubrication.viscosity_mPas == oil["viscosity_mPas"]
    assert parse_scene(named.to_toml()) == named
    told = str(sw.plan(named))
    assert "POM homopolymer against steel shaft" in " ".join(told.split())
    references = "\n".join(sw.plan(named).references)
    assert "budynas2011: Shigley's Mechanical Engineering Design (2011)" in references and "gold2001" in references

    other = named.replace({"material.gear.data": "PA66", "effects.lubrication.oil_temperature_C": 90.0})
    assert other.material.gear.youngs_modulus_MPa == 1850.0 and other.material.gear.name == "PA66"
    assert other.effects.lubrication.viscosity_mPas < oil["viscosity_mPas"]
    own = named.replace({"material.gear.youngs_modulus_MPa": 2900.0, "wear.coefficient_mm2_per_N": 1e-9})
    assert own.material.gear.data is None and own.material.gear.youngs_modulus_MPa == 2900.0
    assert own.wear.data is None and own.material.gear.name == "POM"
    assert named.replace({"effects.lubrication.viscosity_mPas": 20.0}).effects.lubrication.oil_temperature_C is None


def test_one_body_may_be_named_and_the_other_given(spur):
    both = spur.replace(
        {"wear.data": {"gear": "POM_homopolymer_on_steel"}, "wear.coefficient_mm2_per_N": {"pinion": 1e-13}}
    )
    assert both.wear.coefficient("pinion") == 1e-13 and both.wear.coefficient("gear") == 1.21e-9


@pytest.mark.parametrize(
    ("before", "after", "field"),
    [
        ("[material.gear]", '[material.gear]\ndata = "POM"', "material.gear.youngs_modulus_MPa"),
        ("[wear]", '[wear]\ndata = "steel_hard_dry"', "wear.coefficient_mm2_per_N"),
        (
            "[numerics]",
            '[effects.friction]\ndata = "FVA3"\noil_temperature_C = 60\nviscosity_mPas = 7\n[numerics]',
            "effects.friction.viscosity_mPas",
        ),
    ],
)
def test_numbers_beside_a_name_are_its_own(spur, before, after, field):
    problems = problems_of(parse_scene, spur.to_toml().replace(before, after))
    assert "leave it out to take that of" in problems[field].fix


def test_a_name_alone_stands_for_a_table(spur):
    text = spur.to_toml()
    start, end = text.index("[material.gear]"), text.index("[operation]")
    short = text[:start] + text[end:]
    short = short.replace("[material.pinion]", '[material]\ngear = "PEEK"\n\n[material.pinion]')
    assert parse_scene(short).material.gear.youngs_modulus_MPa == 3650.0


def test_a_label_alone_makes_no_plastic(spur):
    with pytest.raises(sw.SceneError, match=r'material.gear.youngs_modulus_MPa.*give data = "POM"'):
        spur.replace({"material.gear.name": "pom"})
    assert spur.replace({"material.gear": {"name": "POM", "youngs_modulus_MPa": 1400.0}}).material.gear.data is None


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"material.gear": "PMO"}, "material.gear.data", 'did you mean "POM"'),
        ({"wear.data": "PA66_on_stel"}, "wear.data", 'did you mean "PA66_on_steel"'),
        ({"wear.data": {"gears": "PA66_on_steel"}}, "wear.data", "give a name or a table"),
        ({"effects.friction": {"data": "FVA3"}}, "effects.friction.oil_temperature_C", "needed by"),
        ({"effects.friction": {"oil_temperature_C": 60.0}}, "effects.friction.data", "needed by"),
    ],
)
def test_wrong_names_are_told(spur, changes, field, words):
    problems = problems_of(spur.replace, changes)
    assert list(problems) == [field] and words in str(problems[field])


def test_the_list_is_told_for_people_and_machines(capsys):
    assert main(["materials"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for _, name in ALL)
    assert "Shigley's Mechanical Engineering Design (2011)" in told
    assert main(["materials", "wear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["wear"] == named_sets(WEAR)


def test_every_source_of_the_core_has_an_entry(spur):
    face_gear = sw.load_scene("face_gear_25x160").replace({"numerics.fidelity": "patch", "numerics.accuracy": 0.02})
    sources = [one for pair, _ in KINDS.values() for one in pair.references]
    sources += [one for table in EFFECTS.values() for one in table.references]
    sources += [one for scene in (spur, face_gear) for choice in physics_choices(scene) for one in choice.references]
    assert len(sources) > 30
    for source in sources:
        assert keys_of(source), source
    known = [source for source in sources if set(keys_of(source)) & set(bibliography())]
    assert len(known) > 30
    assert keys_of("Carter 1926; Johnson 1985, section 8.3 (friction)") == ["carter1926", "johnson1985"]
    assert keys_of("Schlenk 1994, and ISO/TR 14179-2:2001") == ["iso14179-2-2001", "schlenk1994"]
    assert keys_of(titled("budynas2011", "ch. 12")) == ["budynas2011"]


def test_entries_are_bibtex():
    for key, entry in bibliography().items():
        assert entry.count("{") == entry.count("}"), key
        assert re.match(rf"@\w+\{{{re.escape(key)}, \w+ = ", entry), key
    text = bibtex(["Archard 1953, J. Appl. Phys. 24", "Archard 1953, twice", "Somebody 1899, On 5 % & more"], "1.2")
    assert text.count("@article{archard1953") == 1
    assert text.startswith("@software{semiwear") and "version = {1.2}" in text
    assert r"@misc{somebody1899, title = {Somebody 1899, On 5 \% \& more}}" in text


def test_a_run_and_its_scene_are_cited_alike(spur, tmp_path, capsys):
    named = spur.replace({"material.gear": "tin_bronze"})
    result = sw.tooth_contact_analysis(named)
    assert "iso6336-2-1996" in result.attrs["references"]
    tree = sw.loaded_contact(
        named.replace({"numerics.face_slices": 7, "numerics.tooth_compliance": "rigid"}), np.zeros(1)
    )
    assert "@techreport{iso6336-2-1996" in sw.citations(tree)
    sw.save(tree, tmp_path / "a.nc")
    assert main(["cite", str(tmp_path / "a.nc")]) == 0
    assert capsys.readouterr().out.strip() == sw.citations(tree)
    assert "@book{johnson1985" in sw.citations(spur)
    with pytest.raises(sw.SemiwearError, match="no result"):
        sw.citations(type(tree)())

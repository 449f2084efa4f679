"""CalculiX solves exported decks: the load and the root stress of the core, on a worn body."""

import numpy as np
import pytest

import semiwear as sw
from fem_reference.pairs import body_mesh
from fem_reference.root_stress import ROOT_FROM
from fem_reference.tooth_mesh import LOADED
from semiwear.export.whole_teeth import deck_divisions
from validation import calculix
from validation.tests.test_calculix import needs_ccx

TEETH = 7  # a sector: its free cut planes leave root stress alone


@pytest.mark.slow
@needs_ccx
def test_an_exported_deck_has_the_cores_load_and_root_stress(tmp_path):
    scene = sw.load_scene("spur_fzg_c").replace(
        {
            "numerics.face_slices": 11,
            "numerics.roll_positions": 16,
            "numerics.profile_points": 61,
            "numerics.wear_steps": 2,
        }
    )
    tree = sw.simulate(scene)
    assert float(tree["history"].wear_depth_max.isel(wear_step=-1).min()) > 5.0  # um: a worn flank
    deck = tmp_path / "pinion.inp"
    sw.export(tree, deck, body="pinion", teeth=TEETH)
    calculix.run(deck)

    # the reaction is the normal force of the core on all its slices, the pair being alone in contact there
    engagement = tree["engagement"].isel(wear_step=-1)
    busiest = engagement.isel(roll_position=int(np.argmax(engagement.root_stress.sel(body="pinion").values)))
    load = float((busiest.line_load * busiest.line_length).sum())
    assert float(busiest.load_share) == pytest.approx(1.0)
    reaction = calculix.read_total_force(deck.with_suffix(".dat"))
    assert np.linalg.norm(reaction) == pytest.approx(load, rel=0.01)

    # greatest tangential stress of the fillet, as ccx extrapolates it to its nodes
    mesh = body_mesh(scene, "pinion", element="hex20", teeth=TEETH, divisions=deck_divisions(scene))
    fillet = mesh.fillets[0, LOADED]
    nodes, tangent, arc = fillet.nodes[:, ::2], fillet.tangents[:, ::2], fillet.arc[:, ::2]
    frd = calculix.read_frd(deck.with_suffix(".frd"))["STRESS"]
    stress = np.array([[frd[int(node) + 1] for node in row] for row in nodes])
    found = float(calculix._along(stress, tangent)[arc >= ROOT_FROM * arc[-1]].max())
    assert found == pytest.approx(float(busiest.root_stress.sel(body="pinion")), rel=0.05)

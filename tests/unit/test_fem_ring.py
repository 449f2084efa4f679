"""The rest of a ring: condensed teeth are as stiff as meshed ones, and every tooth of a cylindrical pair counts."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

import semiwear as sw
from fem_reference import loaded_contact
from fem_reference.condensation import SupportedBody
from fem_reference.elasticity import ElasticBody
from fem_reference.pairs import body_mesh
from fem_reference.tooth_mesh import LOADED, Divisions

STEEL = {"youngs_modulus": 206000.0, "poissons_ratio": 0.3}
COARSE = Divisions(flank=2, fillet=2, land=1, across=2, depth=2, face_size=7.0)
HELICAL = {"gear_pair.helix_angle_deg": 25.0, "gear_pair.centre_distance_mm": None}
INTERNAL = {
    "gear_pair.gear_teeth": -60,
    "gear_pair.centre_distance_mm": None,
    "gear_pair.gear_profile_shift": 0.0,
    "gear_pair.pinion_profile_shift": 0.2,
}
THICK = {"gear_pair.pinion_bore_radius_mm": 10.0, "gear_pair.gear_rim_thickness_mm": 30.0}


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    return sw.load_scene("spur_fzg_c")


def tip_compliance(scene: sw.Scene, name: str, element: str, explicit: int | None) -> np.ndarray:
    """Motion of three nodes of the middle tooth's tip under forces on them."""
    mesh = body_mesh(scene, name, element=element, teeth=None, divisions=COARSE, explicit=explicit)
    body = ElasticBody(mesh.mesh, element=element, **STEEL)
    stiffness = body.stiffness
    if mesh.rest is not None:
        stiffness = stiffness + mesh.rest.stiffness(body)
    nodes = mesh.flanks[0, LOADED].nodes[-1, [0, -1]]
    loads = np.zeros((body.points.size, 6))
    loads[body.dofs(nodes).ravel(), np.arange(6)] = 1.0
    return SupportedBody(stiffness, body.dofs(mesh.held), body.points).compliance(csr_matrix(loads))


@pytest.mark.parametrize(
    ("changes", "name", "element"),
    [({}, "pinion", "hex20"), (HELICAL, "gear", "hex8i"), (INTERNAL, "gear", "hex8i")],
    ids=["spur", "helical", "internal"],
)
def test_condensed_teeth_are_as_stiff_as_meshed_ones(
    scene: sw.Scene, changes: dict[str, object], name: str, element: str
) -> None:
    """15, 23 and 57 of them: several digits of the doubling."""
    changed = scene.replace(changes | ({} if "gear_pair.gear_teeth" in changes else THICK))
    whole, condensed = (tip_compliance(changed, name, element, explicit) for explicit in (None, 1 if changes else 0))
    np.testing.assert_allclose(condensed, whole, atol=1e-9 * np.abs(whole).max())


@pytest.mark.slow
def test_every_tooth_of_a_cylindrical_pair_counts(scene: sw.Scene) -> None:
    """Of thick bodies a sector is far too soft, the more the thicker they are."""
    thick = scene.replace(THICK | {"gear_pair.pinion_face_width_mm": 7.0, "operation.pinion_torque_Nm": 151.0})
    options = {"elements_per_half_width": 1.0, "element_length": 7.0, "root_stress": False, "strict": False}
    usual, all_teeth = (
        float(loaded_contact(thick, [0.2], **options, **teeth)["mesh_cycle"].transmission_error_loaded[0, 0])
        for teeth in ({}, {"teeth": 24, "pinion_teeth": 16})
    )
    assert usual == pytest.approx(all_teeth, rel=1e-8)

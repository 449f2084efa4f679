"""Free ends of a finite prism: thin slices in plane stress, energy, symmetry and reach."""

import itertools

import numpy as np
import pytest

from semiwear.compliance.open_ends import opened
from semiwear.compliance.prism import PrismSection, prism_section
from semiwear.geometry.section import RackRim, ToothSection

STEEL = {"youngs_modulus": 206000.0, "poissons_ratio": 0.3}
SMALL = {"heights": 5, "fillet_elements": 4, "elements_across": 3, "elements_below": 2, "rack_teeth": 3}


def tooth(pitch: float = 30.0, rim: float = 15.0) -> ToothSection:
    """Straight flanks at 20 degrees, 14 mm high, fillets of 2 mm."""
    height, half_tip, radius, angle = 14.0, 2.5, 2.0, np.radians(20.0)
    centre = np.array([half_tip + (height - radius) * np.tan(angle) + radius / np.cos(angle), radius])
    around = np.linspace(np.pi + angle, 1.5 * np.pi, 41)
    fillet = centre + radius * np.stack([np.cos(around), np.sin(around)], axis=1)
    y = np.linspace(height, fillet[0, 1], 41)
    return ToothSection(
        np.stack([half_tip + (height - y) * np.tan(angle), y], axis=1), y, fillet, RackRim(pitch, -rim)
    )


def parts(prism: PrismSection, z: float, z0: float) -> tuple[np.ndarray, np.ndarray]:
    """Deflection (H, H) [mm/N] of the loaded tooth at z for loads at z0: mirrored ends, and what free ends add."""
    wave = np.arange(len(prism.deflection)) * np.pi / prism.width
    here, there = np.cos(wave * z), np.cos(wave * z0)
    reading, load = (np.einsum("n,nmh->mh", c, prism.end_deflection) for c in (here, there))
    return np.einsum("n,nij->ij", here * there, prism.deflection[:, 2]), reading.T @ load


def stress_parts(prism: PrismSection, z: float, z0: float) -> tuple[np.ndarray, np.ndarray]:
    """Fillet stress (F, H) [MPa/N], likewise."""
    wave = np.arange(len(prism.deflection)) * np.pi / prism.width
    here, there = np.cos(wave * z), np.cos(wave * z0)
    load = np.einsum("n,nmh->mh", there, prism.end_deflection)
    freed = np.einsum("n,nmf->mf", here, prism.end_stress)
    return np.einsum("n,nfj->fj", here * there, prism.stress[:, 1]), freed.T @ load


def test_a_thin_slice_is_in_plane_stress():
    """Mirrored ends hold a slice in plane strain; freed, it is in plane stress: other constants, same code."""
    e, nu = STEEL["youngs_modulus"], STEEL["poissons_ratio"]
    slice_ = {"width": 0.5, "harmonics": 1, **SMALL}
    plane_stress = prism_section(
        tooth(), youngs_modulus=e * (1 + 2 * nu) / (1 + nu) ** 2, poissons_ratio=nu / (1 + nu), end_jumps=0, **slice_
    )
    wanted = plane_stress.deflection[0, 2]
    prism = prism_section(tooth(), end_jumps=40, **slice_, **STEEL)
    held, freed = parts(prism, 0.0, 0.0)
    # the jumps end at the sides and foot of the pitch, which stay in plane strain
    short = wanted - held
    assert (short > 0).all()
    ratio = np.linalg.norm(freed) / np.linalg.norm(short)
    print(f"\nof what plane stress adds, the jumps bring {ratio:.1%}")
    assert 0.95 < ratio <= 1.0
    # stress in the plane hardly knows the difference, though strain and its reading do
    root = np.s_[3:, 2:]
    stress = sum(stress_parts(prism, 0.0, 0.0))[root]
    np.testing.assert_allclose(stress, plane_stress.stress[0, 1][root], atol=0.02 * stress.max())


def test_more_jumps_are_more_compliant_and_energy_is_never_negative():
    """Ritz: every jump adds to the compliance of every load, whatever the load."""
    added = []
    for count in (3, 6):
        prism = prism_section(tooth(), width=40.0, harmonics=17, end_jumps=count, **SMALL, **STEEL)
        places = np.linspace(0.0, 40.0, 5)
        wave = np.arange(17) * np.pi / 40.0
        load = np.einsum("zn,nmh->mzh", np.cos(np.outer(places, wave)), prism.end_deflection)
        load = load.reshape(load.shape[0], -1)
        added.append(load.T @ load)
    scale = np.abs(added[-1]).max()
    for fewer, more in itertools.pairwise(added):
        assert np.linalg.eigvalsh(more - fewer)[0] > -1e-3 * scale  # few harmonics stand for all of them
        assert np.trace(more) > np.trace(fewer)
    assert np.linalg.eigvalsh(added[0])[0] > -1e-9 * scale


@pytest.fixture(scope="module")
def long_prism():
    return prism_section(tooth(), width=160.0, harmonics=65, **SMALL, **STEEL)


def test_ends_do_not_matter_to_a_load_far_from_them(long_prism):
    root = np.s_[3:, 2:]  # loads well above the fillet, and the fillet below its upper end
    for whole, freed in (parts(long_prism, 80.0, 80.0), [p[root] for p in stress_parts(long_prism, 80.0, 80.0)]):
        assert np.abs(freed).max() < 1e-4 * np.abs(whole).max()
    for whole, freed in (parts(long_prism, 5.0, 5.0), [p[root] for p in stress_parts(long_prism, 5.0, 5.0)]):
        assert np.abs(freed).max() > 1e-2 * np.abs(whole).max()


def test_ends_are_alike_and_loads_and_readings_change_places(long_prism):
    near, far = parts(long_prism, 8.0, 20.0)[1], parts(long_prism, 152.0, 140.0)[1]
    np.testing.assert_allclose(near, far, atol=1e-9 * np.abs(near).max())
    np.testing.assert_allclose(near, parts(long_prism, 20.0, 8.0)[1].T, atol=1e-12 * np.abs(near).max())
    near, far = stress_parts(long_prism, 8.0, 20.0)[1], stress_parts(long_prism, 152.0, 140.0)[1]
    np.testing.assert_allclose(near, far, atol=1e-9 * np.abs(near).max())


def test_a_chain_of_springs_cut_open():
    """One jump, one load: the compliance added is the load's pull on the jump squared over the jump's stiffness."""
    weight = np.array([1.0, 2.0, 2.0]) / 7.0
    own = np.array([0.1, 0.3, 0.2])[:, None, None]
    moved = np.array([0.5, -0.2, 0.1])[:, None, None]
    stiffness = np.array([[5.0]])
    deflection, stress = opened(weight, stiffness, own, moved, 2.0 * moved)
    # both ends jump: solve the two by two system by hand
    ends = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])
    whole = (ends * (weight * 5.0 - own[:, 0, 0])) @ ends.T
    pulled = ends @ moved[:, 0, 0]
    wanted = pulled @ np.linalg.solve(whole, pulled)
    assert deflection.sum(axis=0)[:, 0] @ deflection.sum(axis=0)[:, 0] == pytest.approx(wanted)
    np.testing.assert_allclose(stress, 2.0 * deflection)


def test_no_jumps_leave_the_ends_mirrored():
    prism = prism_section(tooth(), width=40.0, harmonics=5, end_jumps=0, **SMALL, **STEEL)
    assert prism.end_deflection.shape[1] == prism.end_stress.shape[1] == 0
    assert not parts(prism, 0.0, 0.0)[1].any()

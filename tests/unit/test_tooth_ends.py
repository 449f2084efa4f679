"""Free ends of a tooth: thin slices in plane stress, a mirror that is one, energy, symmetry and reach."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from semiwear.compliance.polynomials import along_width, derivatives
from semiwear.compliance.prism import prism_section
from semiwear.compliance.tooth_ends import EndEffect, end_effect
from semiwear.compliance.tooth_stretch import HEIGHTS, ORDERS, Stretch, StretchInfluence
from tests.strategies.tooth_sections import trapezoid

STEEL = {"youngs_modulus": 206000.0, "poissons_ratio": 0.3}
SMALL = {"heights": 5, "fillet_elements": 4, "elements_across": 3, "elements_below": 2, "rack_teeth": 3}
TOOTH = trapezoid(pitch=30.0)


@cache
def stretch(width: float, youngs_modulus: float = 206000.0, poissons_ratio: float = 0.3) -> Stretch:
    return Stretch.of(TOOTH, width=width, youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio, name="t")


@cache
def freed(lean: float) -> StretchInfluence:
    """Of a tooth of 40 mm with ends that lean."""
    return replace(stretch(40.0), along=np.sqrt(1.0 - lean**2), lean=lean).influence()


@cache
def ends_of(width: float, slant: float = 0.0) -> EndEffect:
    prism = prism_section(TOOTH, width=width, harmonics=5, **SMALL, **STEEL)
    return end_effect(TOOTH, prism, width=width, slant=slant, **STEEL)


def even_load(height: int = 3) -> np.ndarray:
    """One newton at a height, even along the width."""
    load = np.zeros((ORDERS, HEIGHTS))
    load[0, height] = 1.0
    return load.ravel()


def along(places: np.ndarray, readings: np.ndarray) -> np.ndarray:
    """Readings (P H) at places, (places, H)."""
    return along_width(places, ORDERS) @ readings.reshape(ORDERS, -1)


def test_polynomials_are_orthonormal_and_their_derivatives_are_polynomials():
    at, weight = np.polynomial.legendre.leggauss(2 * ORDERS)
    values = along_width(0.5 * at, ORDERS)
    np.testing.assert_allclose((values * (0.5 * weight)[:, None]).T @ values, np.eye(ORDERS), atol=1e-12)
    inside, step = np.linspace(-0.45, 0.45, 9), 1e-6
    slope = (along_width(inside + step, ORDERS) - along_width(inside - step, ORDERS)) / (2.0 * step)
    np.testing.assert_allclose(along_width(inside, ORDERS) @ derivatives(ORDERS), slope, rtol=1e-6, atol=1e-6)


def test_a_thin_slice_is_in_plane_stress():
    """Mirrored ends hold a slice in plane strain; freed, it is in plane stress: other constants, same code."""
    e, nu = STEEL["youngs_modulus"], STEEL["poissons_ratio"]
    plane_stress = stretch(0.5, e * (1 + 2 * nu) / (1 + nu) ** 2, nu / (1 + nu)).influence(mirrored=True)
    plane_strain = stretch(0.5).influence(mirrored=True)
    free = stretch(0.5).influence()
    wanted, strained, found = (one.bending[:HEIGHTS, :HEIGHTS] for one in (plane_stress, plane_strain, free))
    assert (wanted > 1.01 * strained).all()
    # beside the held foot the slice stays in plane strain
    assert 0.95 < np.linalg.norm(found - strained) / np.linalg.norm(wanted - strained) <= 1.0
    np.testing.assert_allclose(
        free.stress[0, 1:, 2:HEIGHTS],
        plane_stress.stress[0, 1:, 2:HEIGHTS],
        atol=0.02 * plane_stress.stress[0].max(),
    )


def test_mirrored_ends_are_no_ends():
    """An even load deflects and stresses an endless tooth alike everywhere."""
    deflection, _, stress = stretch(40.0).influence(mirrored=True)
    places = np.linspace(-0.5, 0.5, 9)
    moved = along(places, deflection @ even_load())
    np.testing.assert_allclose(moved, np.broadcast_to(moved[4], moved.shape), rtol=1e-9)
    seen = along(places, stress.reshape(-1, ORDERS * HEIGHTS) @ even_load())
    np.testing.assert_allclose(seen, np.broadcast_to(seen[4], seen.shape), rtol=1e-8, atol=1e-9 * seen.max())


@pytest.mark.parametrize("lean", [0.0, 0.4])
def test_no_load_gains_energy(lean):
    found = freed(lean)
    for compliance in (found.deflection, found.bending):
        assert np.linalg.eigvalsh(compliance)[0] > -1e-9 * compliance.max()


def test_bending_is_less_than_deflection():
    """By the dents of the loads, which no load gains from."""
    found = freed(0.0)
    assert np.linalg.eigvalsh(found.deflection - found.bending)[0] > -1e-9 * found.deflection.max()
    assert 0.5 < np.trace(found.bending) / np.trace(found.deflection) < 0.95


def test_ends_matter_to_a_load_near_them_and_not_far_away():
    effect = ends_of(200.0)
    at = np.array([0.0, 0.47])
    own = [along_width(np.array([p]), ORDERS)[0] for p in at]
    far, near = (np.einsum("p,phqg,q->hg", w, effect.deflection.reshape(ORDERS, HEIGHTS, ORDERS, -1), w) for w in own)
    assert np.abs(far[3, 3]) < 0.05 * near[3, 3]
    relief = along(np.array([-0.5, 0.0, 0.5]), effect.stress.reshape(-1, ORDERS * HEIGHTS) @ even_load())
    assert np.abs(relief[1]).max() < 0.03 * np.abs(relief[0]).max()
    np.testing.assert_allclose(relief[0], relief[2], rtol=1e-6, atol=1e-9)


@pytest.mark.slow
def test_oblique_ends_of_the_other_hand_are_the_mirror_image():
    one, other = (ends_of(40.0, slant) for slant in (0.4, -0.4))
    sign = (-1.0) ** np.arange(ORDERS)
    turned = other.deflection.reshape(ORDERS, HEIGHTS, ORDERS, HEIGHTS) * sign[:, None, None, None]
    turned = (turned * sign[:, None]).reshape(one.deflection.shape)
    np.testing.assert_allclose(turned, one.deflection, atol=1e-9 * np.abs(one.deflection).max())


@pytest.mark.slow
@pytest.mark.parametrize("height", [1, 3])
def test_little_obliqueness_changes_little(height):
    """The ends of a helical tooth become those of a spur tooth; the acute corner is first order in the angle."""
    square, little, twice = (ends_of(40.0, slant).stress @ even_load(height) for slant in (0.0, 1e-3, 2e-3))
    step = np.abs(little - square).max()
    assert step < 0.05 * np.abs(square).max()
    np.testing.assert_allclose(twice - square, 2.0 * (little - square), atol=0.02 * step)

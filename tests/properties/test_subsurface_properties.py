"""Stress below any pressure: superposition, mirrors, scales and shifts."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from semiwear.contact.subsurface import greatest_subsurface_stress, maximum_shear, subsurface_stress, von_mises

quick = settings(suppress_health_check=[HealthCheck.too_slow])

lengths = st.floats(-2.0, 0.0).map(lambda exponent: 10.0**exponent)
cells = st.tuples(lengths, lengths)
ratios = st.floats(0.0, 0.5)
values = st.one_of(st.just(0.0), st.floats(1.0, 2000.0))
pressures = array_shapes(min_dims=2, max_dims=2, max_side=9).flatmap(
    lambda shape: arrays(float, shape, elements=values)
)
pairs = array_shapes(min_dims=2, max_dims=2, max_side=9).flatmap(
    lambda shape: st.tuples(arrays(float, shape, elements=values), arrays(float, shape, elements=values))
)

DEPTHS = np.array([0.003, 0.1, 1.0])


def same(one, two, scale):
    np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-11 * max(scale, 1.0))


@given(pairs, cells, ratios, st.floats(-3.0, 3.0))
@quick
def test_stresses_superpose(pair, cell, nu, factor):
    one, two = (subsurface_stress(p, cell=cell, poissons_ratio=nu, depths=DEPTHS) for p in pair)
    both = subsurface_stress(pair[0] + factor * pair[1], cell=cell, poissons_ratio=nu, depths=DEPTHS)
    same(both, one + factor * two, 4.0 * max(pair[0].max(), pair[1].max()))


@given(pressures, cells, ratios)
@quick
def test_mirrored_pressure_gives_mirrored_stress(pressure, cell, nu):
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=nu, depths=DEPTHS)
    in_x = subsurface_stress(pressure[::-1], cell=cell, poissons_ratio=nu, depths=DEPTHS)[:, :, ::-1]
    in_y = subsurface_stress(pressure[:, ::-1], cell=cell, poissons_ratio=nu, depths=DEPTHS)[..., ::-1]
    over = subsurface_stress(pressure.T, cell=cell[::-1], poissons_ratio=nu, depths=DEPTHS).swapaxes(2, 3)
    signs = np.ones((6, 1, 1, 1))
    signs[[3, 4]] = -1.0
    same(in_x, signs * stress, pressure.max())
    signs[[4, 5]] *= -1.0
    same(in_y, signs * stress, pressure.max())
    same(over[[1, 0, 2, 3, 5, 4]], stress, pressure.max())


@given(pressures, cells, ratios)
@quick
def test_the_first_invariant_knows_poissons_ratio_only_as_a_factor(pressure, cell, nu):
    """sigma_z, tau_xz and tau_yz do not know it at all."""
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=nu, depths=DEPTHS)
    rubber = subsurface_stress(pressure, cell=cell, poissons_ratio=0.5, depths=DEPTHS)
    same(stress[:3].sum(axis=0) / (1.0 + nu), rubber[:3].sum(axis=0) / 1.5, pressure.max())
    same(stress[[2, 4, 5]], rubber[[2, 4, 5]], pressure.max())


@given(pressures, cells, ratios)
@quick
def test_greatest_stress_is_finite_and_not_below_the_field(pressure, cell, nu):
    found = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=nu)
    assert np.isfinite([found.von_mises, found.von_mises_depth, found.shear, found.shear_depth]).all()
    if not pressure.any():
        assert found.von_mises == found.shear == 0.0
        return
    given_depths = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=nu, depths=DEPTHS)
    stress = subsurface_stress(pressure, cell=cell, poissons_ratio=nu, depths=DEPTHS)
    loaded = np.ix_(np.flatnonzero(pressure.any(axis=1)), np.flatnonzero(pressure.any(axis=0)))
    for value, measure in ((given_depths.von_mises, von_mises), (given_depths.shear, maximum_shear)):
        assert value >= measure(stress)[:, *loaded].max() * (1.0 - 1e-9)
    # Tresca and von Mises bound one another
    assert found.shear <= found.von_mises / np.sqrt(3.0) * (1.0 + 1e-9)
    assert found.shear >= 0.5 * found.von_mises * (1.0 - 1e-9)


@given(pressures, cells, ratios, st.floats(0.1, 10.0), st.floats(0.1, 10.0))
@quick
def test_greatest_stress_scales_and_shifts(pressure, cell, nu, stronger, larger):
    found = greatest_subsurface_stress(pressure, cell=cell, poissons_ratio=nu)
    padded = stronger * np.pad(pressure, ((2, 1), (0, 3)))
    scaled = greatest_subsurface_stress(padded, cell=(larger * cell[0], larger * cell[1]), poissons_ratio=nu)
    np.testing.assert_allclose(scaled.von_mises, stronger * found.von_mises, rtol=1e-5)
    np.testing.assert_allclose(scaled.shear, stronger * found.shear, rtol=1e-5)

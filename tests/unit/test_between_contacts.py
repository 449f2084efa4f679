import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear.compliance.half_space import HalfSpace
from semiwear.contact.between_contacts import BetweenContacts, border_squared_over_area

shapes = st.tuples(st.integers(1, 40), st.integers(1, 40))
cells = st.tuples(st.sampled_from([1.0, 0.3, 20.0]), st.just(1.0))


def drawn(shape: tuple[int, int], share: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells in contact and values there."""
    rng = np.random.default_rng(seed)
    contact = rng.random(shape) < share
    return contact, np.where(contact, rng.standard_normal(shape), 0.0)


@given(shapes, cells, st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_values_in_contact_stay_and_others_lie_between_them(shape, cell, share, seed):
    contact, values = drawn(shape, share, seed)
    filled = BetweenContacts(shape, cell).fill(values.copy(), contact)
    assert np.array_equal(filled[contact], values[contact])
    assert np.abs(filled).max() <= np.abs(values).max() * (1.0 + 1e-6)


@given(shapes, cells, st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_collect_is_the_transpose_of_fill(shape, cell, share, seed):
    contact, values = drawn(shape, share, seed)
    between, other = BetweenContacts(shape, cell), np.random.default_rng(seed + 1).standard_normal(shape)
    work = float((between.fill(values.copy(), contact) * other).sum())
    collected = between.collect(other.copy(), contact)
    assert not collected[~contact].any()
    size = np.linalg.norm(values) * np.linalg.norm(other) + 1e-300
    assert abs(float((values * collected).sum()) - work) <= 1e-5 * size


def test_a_single_contact_fades_out_with_the_square_of_the_distance():
    contact, values = np.zeros((2, 128, 128))
    contact[64, 64] = values[64, 64] = 1.0
    filled = BetweenContacts((128, 128), (1.0, 1.0)).fill(values, contact.astype(bool))
    far = [filled[64:, 64:][reach : 2 * reach, :reach].mean() * reach**2 for reach in (2, 4, 8, 16)]
    assert max(far) < 2.0 * min(far)


@pytest.mark.parametrize("at", [5, 20, 21, 32])
@pytest.mark.parametrize("along", [0, 1])
def test_beside_a_line_of_contacts_values_fall_with_the_distance(at, along):
    contact = np.zeros((50, 12), dtype=bool)
    contact[at] = True
    contact = np.ascontiguousarray(np.moveaxis(contact, 0, along))
    filled = np.moveaxis(BetweenContacts(contact.shape, (1.0, 1.0)).fill(contact.astype(float), contact), along, 0)
    assert (np.diff(filled[: at + 1], axis=0) >= 0.0).all() and (np.diff(filled[at:], axis=0) <= 0.0).all()
    assert (filled[[at - 1, at + 1]] < 0.7).all()


@pytest.mark.parametrize("cell", [(1.0, 4.0), (4.0, 1.0)])
def test_on_long_cells_a_single_contact_fades_out_as_far_along_either_axis(cell):
    """Beyond the sides of a cell: means over squares that are as wide as they are far away."""
    shape = int(128 / cell[0]), int(128 / cell[1])
    contact, i, j = np.zeros(shape, dtype=bool), shape[0] // 2, shape[1] // 2
    contact[i, j] = True
    filled = BetweenContacts(shape, cell).fill(contact.astype(float), contact)[i:, j:]
    for far in (8.0, 16.0):
        m, n = int(far / cell[0]), int(far / cell[1])
        assert filled[m : 2 * m, :n].mean() == pytest.approx(filled[:m, n : 2 * n].mean(), rel=0.2)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_the_inverse_of_the_cells_in_contact_is_nearer_than_that_of_the_whole_surface(share):
    shape, cell, rng = (24, 24), (1.0, 1.0), np.random.default_rng(3)
    waves = np.hypot(np.fft.fftfreq(24)[:, None], np.fft.fftfreq(24))
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * np.exp(-((waves * 6.0) ** 2))).real
    contact = heights > np.quantile(heights, 1.0 - share)
    half_space, between, pressed = HalfSpace(shape, cell), BetweenContacts(shape, cell), np.flatnonzero(contact)

    def columns(function):
        units = np.zeros((pressed.size, *shape))
        units.reshape(pressed.size, -1)[np.arange(pressed.size), pressed] = 1.0
        return np.array([function(unit)[contact] for unit in units])

    def spread(inverse):
        values = np.linalg.eigvals(columns(inverse) @ columns(half_space.apply)).real
        assert values.min() > 0.5
        return values.max() / values.min()

    plain = spread(half_space.precondition)
    continued = spread(
        lambda unit: between.collect(half_space.precondition(between.fill(unit.copy(), contact)), contact)
    )
    assert continued < 0.8 * plain


def test_one_round_contact_has_few_cells_at_its_edge_and_many_have_more():
    x = np.arange(64) - 31.5
    disc = np.hypot(x[:, None], x) < 20.0
    assert border_squared_over_area(disc) == pytest.approx(10.0, rel=0.2)
    assert border_squared_over_area(np.tile(disc, (4, 4))) == pytest.approx(160.0, rel=0.2)
    assert border_squared_over_area(np.zeros((3, 3), bool)) == 0.0

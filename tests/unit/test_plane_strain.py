"""Influence between cells of bands that lie apart."""

from math import log

import numpy as np
import pytest

from semiwear.contact.plane_strain import influences, mean_log


@pytest.mark.parametrize(("bands", "per_band"), [(1, 32), (2, 24), (3, 16)])
def test_cells_deflect_by_the_mean_of_both_means_of_the_logarithm(bands: int, per_band: int) -> None:
    random = np.random.default_rng(bands)
    widths = random.uniform(0.01, 0.05, bands)
    starts = np.cumsum(np.concatenate([[0.0], widths[:-1] * per_band + random.uniform(1e-3, 0.3, bands - 1)]))
    x = (starts[:, None] + widths[:, None] * (np.arange(per_band) + 0.5)).ravel()
    width, span, n = np.repeat(widths, per_band), 4.0, bands * per_band
    found, expected = np.zeros((n, n)), np.empty((n, n))
    influences(x, width, n, per_band, span, found)
    for i in range(n):
        for j in range(n):
            means = mean_log(abs(x[i] - x[j]), width[i]), mean_log(abs(x[i] - x[j]), width[j])
            expected[i, j] = log(2.0 * span) - 0.5 * (means[0] + means[1])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
    assert np.linalg.eigvalsh(found).min() > 0.0

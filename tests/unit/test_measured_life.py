"""Lives with uncertainty: closed forms against Monte Carlo."""

import numpy as np
import pytest
from scipy.stats import norm

from semiwear.errors import SceneError
from semiwear.measured.life_spread import LifeSpread, log_deviation


def test_a_coefficient_of_variation_of_one_half():
    """Of log-normal draws with that deviation of the logarithm, one standard deviation is half of the mean."""
    draws = np.exp(log_deviation(0.5) * np.random.default_rng(1).standard_normal(400_000))
    assert draws.std() / draws.mean() == pytest.approx(0.5, rel=0.01)
    assert log_deviation(0.5) == pytest.approx(0.4724, abs=1e-4)
    assert log_deviation(0.0) == 0.0


def test_quantiles_against_monte_carlo():
    """A life of 1e9 meshes at k: k of the next part scatters about a median that one measured part tells."""
    rng = np.random.default_rng(2)
    count, scatter, fit = 400_000, log_deviation(0.5), 0.1
    true_median = 1.0
    measured = true_median * np.exp(scatter * rng.standard_normal(count) + fit * rng.standard_normal(count))
    chosen = true_median * np.exp(scatter * rng.standard_normal(count))
    # life of the next part over the life that the measured coefficient tells
    ratio = measured / chosen
    spread = LifeSpread("gear", 60.0, 1e9, np.sqrt(2.0 * scatter**2 + fit**2))
    for share in (0.05, 0.1, 0.5, 0.9):
        assert spread.quantile(share) == pytest.approx(1e9 * np.quantile(ratio, share), rel=0.01)


def test_measured_scatter_against_monte_carlo():
    """Of four parts, their own scatter: the life B10 falls short in one case of ten, whatever the true scatter."""
    rng = np.random.default_rng(3)
    count, parts, true = 100_000, 4, 0.37
    logs = true * rng.standard_normal((count, parts))
    following = true * rng.standard_normal(count)
    deviation = logs.std(axis=1, ddof=1) * np.sqrt(1.0 + 1.0 / parts)
    place = np.log(LifeSpread("gear", 60.0, 1.0, 1.0, freedom=parts - 1.0).quantile(0.1))
    assert place < norm.ppf(0.1)
    shorter = -following < -logs.mean(axis=1) + place * deviation
    assert shorter.mean() == pytest.approx(0.1, abs=0.005)


def test_quantiles_in_order_and_in_words():
    spread = LifeSpread("pinion", 40.0, 2e8, 0.5, k_scatter=0.5, hours_per_mesh=1e-5)
    low, middle, high = spread.quantiles()
    assert low < middle == 2e8 < high
    assert low * high == pytest.approx(middle**2)
    text = str(spread)
    for word in ("pinion", "40 um", "B10", "B50 2e+08 meshes (2000 h)", "B90", "50 %"):
        assert word in text.replace("\n    ", " ")
    with pytest.raises(SceneError, match="share"):
        spread.quantile(0.0)

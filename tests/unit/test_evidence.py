"""What measured values say of amounts of shapes: against closed forms, and as often right as it says."""

import numpy as np
import pytest
from scipy.stats import binom, multivariate_normal, multivariate_t, norm
from scipy.stats import t as student

from semiwear.inference.evidence import (
    LONGEST,
    SHORTEST,
    Evidence,
    FlankNoise,
    _draws_about,
    _effective,
    _spread,
    known_noise,
    unknown_noise,
)

ROWS, COLUMNS = 17, 11
PROFILE, FACE = np.linspace(0.0, 10.0, ROWS), np.linspace(0.0, 80.0, COLUMNS)
P, F = np.meshgrid(PROFILE / 10.0, FACE / 80.0, indexing="ij")
SHAPES = np.stack([np.exp(-(((P - 0.1) / 0.15) ** 2)) * (1.0 + 0.3 * F), np.sin(3.0 * P) * F], -1)
MOVEMENTS = np.stack([np.ones_like(P), F], -1)


def test_known_noise_is_weighted_least_squares() -> None:
    random = np.random.default_rng(0)
    shapes, values = random.standard_normal((20, 3)), random.standard_normal(20)
    error = random.uniform(0.5, 2.0, 20)
    found = known_noise(values, shapes, np.zeros((20, 0)), error)
    amounts = random.standard_normal((5, 3))
    expected = -0.5 * np.sum(((values - amounts @ shapes.T) / error) ** 2, axis=1)
    told = found.log_likelihood(amounts)
    np.testing.assert_allclose(told - told[0], expected - expected[0], rtol=1e-8)
    assert found.deviation == np.median(error)


def test_the_misfit_counts_all_that_was_seen() -> None:
    """Of noise that is known: chi over the values, the movement taken out; shapes cannot make what is added here."""
    random = np.random.default_rng(2)
    shapes, free, error = random.standard_normal((20, 2)), np.ones((20, 1)), random.uniform(0.5, 2.0, 20)
    amounts = np.array([1.0, -2.0])
    values = shapes @ amounts + error * random.standard_normal(20)
    values[3] += 50.0
    found = known_noise(values, shapes, free, error)
    rest = values - shapes @ amounts
    moved = np.sum(rest / error**2) / np.sum(1.0 / error**2)
    chi = np.sqrt(np.sum(((rest - moved) / error) ** 2) / 19.0)
    assert found.misfit(amounts) == pytest.approx(chi) and chi > 3.0
    assert found.widened(1e-12 * np.eye(2)).misfit(amounts) == pytest.approx(chi)


def test_a_movement_that_is_left_open_says_nothing() -> None:
    """Adding any of it changes nothing, and it widens what is told of the shapes."""
    random = np.random.default_rng(1)
    shapes, values, error = random.standard_normal((20, 2)), random.standard_normal(20), np.ones(20)
    free = np.ones((20, 1))
    one, other = (known_noise(values + shift, shapes, free, error) for shift in (0.0, 7.0))
    np.testing.assert_allclose(one.centres, other.centres)
    tight = known_noise(values, shapes, np.zeros((20, 0)), error)
    assert np.all(np.linalg.eigvalsh(tight.precisions[0] - one.precisions[0]) >= -1e-9)


def test_errors_of_predictions_add_to_the_noise() -> None:
    """The covariance of a normal likelihood and that of the prediction: their sum."""
    random = np.random.default_rng(2)
    found = known_noise(random.standard_normal(20), random.standard_normal((20, 3)), np.zeros((20, 0)), np.ones(20))
    error = np.diag([0.3, 0.0, 2.0])
    expected = np.linalg.inv(np.linalg.inv(found.precisions[0]) + error)
    np.testing.assert_allclose(found.widened(error).precisions[0], expected)


def test_a_mixture_of_students_t() -> None:
    random = np.random.default_rng(3)
    centres, roots = random.standard_normal((3, 2)), random.standard_normal((3, 2, 2))
    precisions = np.einsum("dij,dkj->dik", roots, roots) + 0.5 * np.eye(2)
    logs = np.log([0.2, 0.5, 0.3])
    found = Evidence(logs, centres, precisions, 7.0, 1.0)
    points = random.standard_normal((6, 2))
    parts = [
        multivariate_t(c, np.linalg.inv(p), df=7.0).pdf(points) for c, p in zip(centres, precisions, strict=True)
    ]
    expected = np.log(np.exp(logs) @ np.array(parts))
    told = found.log_likelihood(points)
    np.testing.assert_allclose(told - told[0], expected - expected[0], rtol=1e-9)
    # weights count against one another, whatever their sum
    heavy = Evidence(logs + 3.0, centres, precisions, 7.0, 1.0)
    np.testing.assert_allclose(heavy.precision, 0.2 * precisions[0] + 0.5 * precisions[1] + 0.3 * precisions[2])


class NormalNoise(FlankNoise):
    """A flank whose noise parameters, in logits, are normal: they are the amounts, the deviation the first's exp."""

    MEAN = np.array([0.3, -0.5, 0.2])
    COVARIANCE = np.array([[0.5, 0.3, 0.0], [0.3, 0.8, -0.2], [0.0, -0.2, 0.4]])

    def conditional(self, logits):
        density = multivariate_normal(self.MEAN, self.COVARIANCE).logpdf(logits)
        return float(density), logits, np.diag([1.0, 2.0, 3.0]), float(np.exp(logits[0]))


def test_draws_stand_for_the_density_that_they_are_not_drawn_from() -> None:
    """Moments of a normal density from draws of Student's t: within what 200 draws leave open."""
    values = np.zeros((5, 4))
    flank = NormalNoise(PROFILE[:5], FACE[:4], values, np.zeros((5, 4, 3)), np.zeros((5, 4, 2)))
    found = unknown_noise(flank)
    weights = np.exp(found.log_weights) / np.exp(found.log_weights).sum()
    mean = weights @ found.centres
    away = found.centres - mean
    deviations = np.sqrt(np.diagonal(flank.COVARIANCE))
    np.testing.assert_allclose((mean - flank.MEAN) / deviations, 0.0, atol=0.25)
    ratios = ((weights[:, None] * away).T @ away - flank.COVARIANCE) / np.outer(deviations, deviations)
    np.testing.assert_allclose(ratios, 0.0, atol=0.3)
    # of a lognormal deviation, the mean
    assert found.deviation == pytest.approx(np.exp(0.3 + 0.25), rel=0.2)
    squares = np.exp(2.0 * found.centres[:, 0])
    np.testing.assert_allclose(found.precisions, np.diag([1.0, 2.0, 3.0]) / squares[:, None, None])
    assert found.freedom == 20 - 3 - 2


def test_draws_are_repeated_until_enough_of_them_are_effective() -> None:
    """Begun far away and much too narrow, two rounds of 200 draws are not enough."""
    flank = NormalNoise(PROFILE[:5], FACE[:4], np.zeros((5, 4)), np.zeros((5, 4, 3)), np.zeros((5, 4, 2)))
    drawn, weights = _draws_about(flank, flank.MEAN + 1.5, 1e-2 * np.eye(3), np.random.default_rng(0))
    assert 400 < len(drawn) < 1200 and _effective(weights) >= 60.0


class BentNoise(FlankNoise):
    """A density of logits far from normal: the second lies about a parabola of the first."""

    def conditional(self, logits):
        bent = norm.logpdf(logits[1], 0.3 * logits[0] ** 2, 0.5)
        density = norm.logpdf(logits[0], 0.0, 1.5) + bent + norm.logpdf(logits[2], 0.0, 1.0)
        return float(density), logits, np.eye(3), 1.0


def test_draws_follow_a_density_that_is_far_from_normal() -> None:
    """Means of eight sets of draws; drawn about the maximum, as its curvature says, they spread by a third less."""
    flank = BentNoise(PROFILE[:5], FACE[:4], np.zeros((5, 4)), np.zeros((5, 4, 3)), np.zeros((5, 4, 2)))
    means, variances = [], []
    for seed in range(8):
        found = unknown_noise(flank, seed)
        weights = np.exp(found.log_weights - found.log_weights.max())
        weights /= weights.sum()
        assert 1.0 / np.sum(weights**2) > 50.0
        means.append(weights @ found.centres)
        variances.append(weights @ (found.centres - means[-1]) ** 2)
    np.testing.assert_allclose(np.mean(means, axis=0), [0.0, 0.3 * 1.5**2, 0.0], atol=0.25)
    expected = [1.5**2, 0.5**2 + 2.0 * (0.3 * 1.5**2) ** 2, 1.0]
    np.testing.assert_allclose(np.mean(variances, axis=0)[[0, 2]], [expected[0], expected[2]], rtol=0.15)
    assert np.mean(variances, axis=0)[1] == pytest.approx(expected[1], rel=0.35)


def test_draws_spread_as_the_curvature_says_and_no_wider_than_logits_matter() -> None:
    covariance = NormalNoise.COVARIANCE
    curvature = np.linalg.inv(covariance)

    def hill(at: np.ndarray) -> float:
        away = at - 1.0
        return float(0.5 * away @ curvature @ away)

    np.testing.assert_allclose(_spread(hill, np.ones(3)), covariance, rtol=1e-8, atol=1e-9)
    flat = _spread(lambda at: float(at[0] ** 2 + 1e-4 * at[1] ** 2 - at[2] ** 2), np.zeros(3))
    np.testing.assert_allclose(flat, np.diag([0.5, 25.0, 25.0]), rtol=1e-8, atol=1e-9)


def noise(random: np.random.Generator) -> np.ndarray:
    factors = []
    for place in (PROFILE, FACE):
        step, extent = place[1] - place[0], place[-1]
        length = np.exp(random.uniform(np.log(SHORTEST * step), np.log(LONGEST * extent)))
        along = np.exp(-np.abs(place[:, None] - place) / length) + 1e-10 * np.eye(place.size)
        factors.append(np.linalg.cholesky(along))
    share = random.uniform()
    alike = factors[0] @ random.standard_normal(P.shape) @ factors[1].T
    return np.sqrt(share) * alike + np.sqrt(1.0 - share) * random.standard_normal(P.shape)


@pytest.mark.slow
def test_intervals_under_unknown_correlated_noise_hold_as_often_as_they_say() -> None:
    """Noise parameters from their prior: 90 % intervals of two amounts hold in 90 %, as far as 60 flanks tell."""
    random, held = np.random.default_rng(4), np.zeros(2)
    true, count = np.array([3.0, 2.0]), 60
    for _ in range(count):
        values = SHAPES @ true + MOVEMENTS @ random.standard_normal(2) * 5.0 + 0.3 * noise(random)
        found = unknown_noise(FlankNoise(PROFILE, FACE, values, SHAPES, MOVEMENTS))
        deviations = np.sqrt(np.diagonal(np.linalg.inv(found.precisions), axis1=1, axis2=2))
        weights = np.exp(found.log_weights - found.log_weights.max())
        below = weights @ student.cdf((true - found.centres) / deviations, found.freedom) / weights.sum()
        held += (below > 0.05) & (below < 0.95)
    for hits in held:
        assert binom.cdf(hits, count, 0.9) > 0.002 and binom.sf(hits - 1, count, 0.9) > 0.002


def test_noise_parameters_are_told() -> None:
    """Of white noise, the deviation; the share that is alike is small."""
    random = np.random.default_rng(5)
    values = SHAPES @ np.array([3.0, 2.0]) + 0.4 * random.standard_normal(P.shape)
    found = unknown_noise(FlankNoise(PROFILE, FACE, values, SHAPES, MOVEMENTS))
    assert found.deviation == pytest.approx(0.4, rel=0.15)


def test_correlation_lengths_reach_from_steps_to_extents() -> None:
    flank = FlankNoise(PROFILE, FACE, P, SHAPES, MOVEMENTS)
    shortest, longest = flank.limits()
    np.testing.assert_allclose(np.exp(shortest), [SHORTEST * 10.0 / (ROWS - 1), SHORTEST * 80.0 / (COLUMNS - 1)])
    np.testing.assert_allclose(np.exp(longest), [LONGEST * 10.0, LONGEST * 80.0])


def test_density_of_noise_is_the_restricted_likelihood() -> None:
    """Harville 1974, with the whole covariance instead of its factors; so is the deviation."""
    values = SHAPES @ [1.0, 0.5] + np.random.default_rng(4).standard_normal(P.shape)
    flank = FlankNoise(PROFILE, FACE, values, SHAPES, MOVEMENTS)
    every = np.concatenate([SHAPES, MOVEMENTS], axis=-1).reshape(P.size, -1)

    def directly(logits: np.ndarray) -> tuple[float, float]:
        share, lengths = flank.parameters(logits)
        assert share == pytest.approx(1.0 / (1.0 + np.exp(-logits[0])))
        along, across = (
            np.exp(-np.abs(x[:, None] - x) / one) for x, one in zip((PROFILE, FACE), lengths, strict=True)
        )
        covariance = (1.0 - share) * np.eye(P.size) + share * np.kron(along, across)
        solved = np.linalg.solve(covariance, every)
        rest = values.ravel() - every @ np.linalg.solve(every.T @ solved, solved.T @ values.ravel())
        squares = rest @ np.linalg.solve(covariance, rest)
        logs = [np.linalg.slogdet(one)[1] for one in (covariance, every.T @ solved)]
        prior = np.sum(np.log(1.0 / (1.0 + np.exp(-logits))) + np.log(1.0 / (1.0 + np.exp(logits))))
        freedom = P.size - every.shape[1]
        return float(-0.5 * (sum(logs) + freedom * np.log(squares)) + prior), float(np.sqrt(squares / freedom))

    one, other = np.array([-1.0, 0.5, 0.2]), np.array([2.0, -0.7, 1.0])
    told = flank.conditional(one)[0] - flank.conditional(other)[0]
    assert told == pytest.approx(directly(one)[0] - directly(other)[0], rel=1e-8)
    assert flank.conditional(one)[3] == pytest.approx(directly(one)[1], rel=1e-8)

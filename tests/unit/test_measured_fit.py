"""Fit of predicted to measured wear on a stored model: coverage of the intervals, outliers, and no information."""

import numpy as np
import pytest
from scipy.stats import binom
from scipy.stats import t as student

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.measured.correlated import correlation_of, estimate
from semiwear.measured.fit import datum_modes, fit_part
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading, WearCurve
from semiwear.measured.rigid import DATUM
from semiwear.measured.robust import one_sided_fit
from semiwear.measured.worn import MeasuredWear
from semiwear.meshing.flank_grid import flank_grid
from tests.strategies.measured import grid_on

DRAWS = 200
NOISE = 5e-4  # mm


@pytest.fixture(scope="module")
def flank():
    return nominal_flank(sw.load_scene("spur_fzg_c"))


def pattern(p, f):
    """A wear depth [mm] like that of a spur gear: most at the root, none at the pitch circle."""
    return 6e-3 * (np.exp(-((p / 0.3) ** 2)) + 0.4 * np.maximum(p - 0.6, 0.0)) * (1.0 - 0.2 * (2.0 * f - 1.0) ** 2)


class Model:
    """A part whose wear grows linearly up to `meshes` = 1 and beyond."""

    def __init__(self, flank, rows=17, columns=11):
        self.flank = flank
        self.face, self.profile, self.p, self.f = grid_on(flank, rows, columns)
        self.shape = pattern(self.p, self.f)
        meshes = np.linspace(0.0, 2.0, 9)
        self.curve = WearCurve(meshes, meshes[:, None] * self.shape.ravel())

    def measured(self, error, meshes=1.0, rotation=3e-5):
        inside = np.ones(self.p.shape, dtype=bool)
        bare = MeasuredWear(self.flank, self.face, self.profile, inside, np.zeros(self.p.shape))
        _, modes = datum_modes(bare, DATUM)
        depth = meshes * self.shape + rotation * modes[..., 0] + error
        return MeasuredWear(self.flank, self.face, self.profile, inside, depth)


@pytest.fixture(scope="module")
def model(flank):
    return Model(flank)


def noise_of(model, kind, rng):
    """White noise, or three quarters of it correlated over 0.12 of the profile and 0.15 of the face."""
    white = rng.standard_normal(model.p.shape)
    if kind == "white":
        return NOISE * white
    factors = []
    for places, length in ((model.p[:, 0], 0.12), (model.f[0], 0.15)):
        factors.append(np.linalg.cholesky(np.exp(-np.abs(places[:, None] - places) / length)))
    return NOISE * (np.sqrt(0.75) * factors[0] @ rng.standard_normal(model.p.shape) @ factors[1].T + 0.5 * white)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["white", "correlated"])
def test_intervals_hold_as_often_as_they_say(model, kind):
    """95 % of 200 draws, within the binomial bounds of 99.9 %; the rotation is found as well."""
    rng = np.random.default_rng(11)
    held, ratios, errors = 0, [], []
    for _ in range(DRAWS):
        fit = fit_part(model.curve, model.measured(noise_of(model, kind, rng)), DATUM)
        low, high = fit.interval(0.95)
        held += low <= 1.0 <= high
        ratios.append(np.log(fit.meshes))
        errors.append(fit.log_error)
    low, high = binom.interval(0.999, DRAWS, 0.95)
    assert low <= held <= high, held
    assert abs(np.mean(ratios)) < 4.0 * np.std(ratios) / np.sqrt(DRAWS) + np.var(ratios)
    # the uncertainty told is the scatter that there is
    assert np.mean(errors) == pytest.approx(np.std(ratios), rel=0.2)


def test_counting_every_point_would_hold_far_too_seldom(model):
    """What the correlation is for: the plain interval of least squares holds in much less than 95 % of the cases."""
    rng = np.random.default_rng(12)
    held = 0
    for _ in range(40):
        fit = fit_part(model.curve, model.measured(noise_of(model, "correlated", rng)), DATUM)
        assert fit.effective_points < 0.6 * fit.points
        plain = fit.log_error * np.sqrt(fit.effective_points / fit.points)
        held += abs(np.log(fit.meshes)) <= 1.96 * plain
    assert held < 36


def test_correlation_is_found(model):
    rng = np.random.default_rng(13)
    rows, columns = 61, 41
    profile, face = np.linspace(0.0, 6.0, rows), np.linspace(-7.0, 7.0, columns)
    factors = [
        np.linalg.cholesky(np.exp(-np.abs(places[:, None] - places) / length))
        for places, length in ((profile, 0.5), (face, 1.0))
    ]
    found = []
    for _ in range(5):
        values = np.sqrt(0.6) * factors[0] @ rng.standard_normal((rows, columns)) @ factors[1].T
        values = values + np.sqrt(0.4) * rng.standard_normal((rows, columns))
        values -= values.mean()
        one = correlation_of(values, np.ones((rows, columns, 1)), profile, face)
        found.append((one.share, one.profile_length, one.face_length))
    assert np.mean(found, axis=0) == pytest.approx((0.6, 0.5, 1.0), rel=0.25)


def test_uncertainty_of_a_mean_is_that_of_the_textbook():
    """White noise, one parameter: s/sqrt(n), and n - 1 degrees of freedom."""
    values = np.random.default_rng(1).standard_normal((40, 30))
    mean = values.mean()
    found = estimate(values - mean, np.ones((40, 30, 1)), np.ones((40, 30)), np.arange(40.0), np.arange(30.0))
    assert found.errors[0] == pytest.approx(values.std(ddof=1) / np.sqrt(1200.0), rel=0.25)
    assert found.freedom == pytest.approx(1199.0, rel=0.1)


@pytest.mark.parametrize("meshes", [0.02, 0.3, 1.0, 1.6])
def test_without_noise_the_meshes_come_back(model, meshes):
    fit = fit_part(model.curve, model.measured(0.0, meshes), DATUM)
    assert fit.meshes == pytest.approx(meshes, rel=1e-6)
    assert fit.datum["rotation"] == pytest.approx(3e-5, rel=1e-5)
    assert fit.explained == pytest.approx(1.0)
    np.testing.assert_allclose(fit.aligned, meshes * model.shape, atol=1e-9)


def test_the_datum_does_not_matter(model):
    error = noise_of(model, "white", np.random.default_rng(2))
    first, second = (fit_part(model.curve, model.measured(error, rotation=r), DATUM) for r in (0.0, 2e-4))
    assert first.meshes == pytest.approx(second.meshes, rel=1e-7)
    assert first.log_error == pytest.approx(second.log_error, rel=1e-5)
    apart = second.datum["rotation"] - first.datum["rotation"]
    assert apart == pytest.approx(2e-4, rel=1e-6)


def test_outliers_weigh_little_in_a_robust_fit(model):
    rng = np.random.default_rng(4)
    error = noise_of(model, "white", rng)
    error[rng.random(error.shape) < 0.05] -= 0.03  # dust
    plain, robust = (fit_part(model.curve, model.measured(error), DATUM, robust=flag) for flag in (False, True))
    assert abs(np.log(robust.meshes)) < 2.0 * robust.log_error
    assert robust.log_error < 0.4 * plain.log_error


def test_robust_without_outliers_is_nearly_least_squares(model):
    error = noise_of(model, "white", np.random.default_rng(5))
    plain, robust = (fit_part(model.curve, model.measured(error), DATUM, robust=flag) for flag in (False, True))
    assert abs(np.log(robust.meshes / plain.meshes)) < plain.log_error
    assert robust.log_error == pytest.approx(plain.log_error, rel=0.35)


@pytest.mark.parametrize("meshes", [0.0, 0.002, -0.5])
def test_wear_below_the_noise_says_nothing(model, meshes):
    """As much of it as one draw of noise makes up, or the opposite of wear."""
    error = noise_of(model, "white", np.random.default_rng(8))
    with pytest.raises(SceneError, match="says nothing of k"):
        fit_part(model.curve, model.measured(error, meshes), DATUM)


def test_a_few_grains_of_dust_do_not_hold_the_one_sided_fit():
    rng = np.random.default_rng(9)
    x = np.linspace(-1.0, 1.0, 600)
    modes = np.stack([np.ones(600), x], axis=1)
    wear = 0.02 * np.maximum(1.0 - (x / 0.5) ** 2, 0.0)
    values = modes @ [0.01, -0.004] - wear + NOISE * rng.standard_normal(600)
    values[rng.choice(600, 6, replace=False)] += 0.03
    amounts, weights = one_sided_fit(values, modes, np.ones(600, dtype=bool), NOISE)
    np.testing.assert_allclose(amounts, [0.01, -0.004], atol=0.5 * NOISE)
    assert weights[np.argmax(wear)] == 0.0


def test_readings_between_nodes(flank):
    """A plane over profile and face is read exactly between the outermost slices."""
    faces = np.linspace(-6.5, 6.5, 14)
    grid = flank_grid(flank.pair, faces, 41)
    face, profile, *_ = grid_on(flank, 9, 7, 0.06)
    values = 2.0 + 0.5 * grid.profile - 0.3 * faces[:, None]
    read = FlankReading.of(grid, face.ravel(), profile.ravel()).read(values)
    np.testing.assert_allclose(read, (2.0 + 0.5 * profile - 0.3 * face).ravel(), rtol=1e-12)


def test_intervals_are_students(model):
    fit = fit_part(model.curve, model.measured(noise_of(model, "white", np.random.default_rng(3))), DATUM)
    assert fit.interval(0.5)[0] > fit.interval(0.95)[0] and fit.interval(0.5)[1] < fit.interval(0.95)[1]
    low, high = fit.interval(0.9)
    half = student.ppf(0.95, fit.freedom) * fit.log_error
    np.testing.assert_allclose(np.log([low, high]) - np.log(fit.meshes), [-half, half])

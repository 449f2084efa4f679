"""Fit of predicted to measured wear on a stored model: coverage of the intervals, outliers, and no information."""

import numpy as np
import pytest
from scipy.stats import binom
from scipy.stats import t as student

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.measured.correlated import correlation_of, estimate
from semiwear.measured.fit import best_meshes, datum_modes, fit_part
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading, WearCurve
from semiwear.measured.rigid import DATUM
from semiwear.measured.robust import huber_weights, one_sided_fit
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

    def measured(self, error, meshes=1.0, rotation=3e-5, inside=None):
        inside = np.ones(self.p.shape, dtype=bool) if inside is None else inside
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


def dusty(model):
    rng = np.random.default_rng(4)
    error = noise_of(model, "white", rng)
    error[rng.random(error.shape) < 0.05] -= 0.03
    return error


def test_outliers_weigh_little_in_a_robust_fit(model):
    error = dusty(model)
    plain, robust = (fit_part(model.curve, model.measured(error), DATUM, robust=flag) for flag in (False, True))
    assert abs(np.log(robust.meshes)) < 2.0 * robust.log_error
    assert robust.log_error < 0.4 * plain.log_error


@pytest.mark.parametrize("place", [(1, 3), (3, 5), (8, 5), (15, 9)])
@pytest.mark.parametrize("height", [0.2, 0.05, -0.2])
def test_a_single_outlier_far_off_does_not_hold_a_robust_fit(model, place, height):
    """With unit weights it draws the fit to either end of the curve."""
    error = noise_of(model, "white", np.random.default_rng(5))
    clean = fit_part(model.curve, model.measured(error), DATUM, robust=True)
    error[place] += height
    found = fit_part(model.curve, model.measured(error), DATUM, robust=True)
    assert abs(np.log(found.meshes / clean.meshes)) < 0.5 * clean.log_error


def test_a_robust_fit_is_the_least_of_its_own_weighted_squares(model):
    """No motion and no meshes are left to gain, under the weights of its residuals; the share explained likewise."""
    measured = model.measured(dusty(model))
    fit = fit_part(model.curve, measured, DATUM, robust=True)
    rest = fit.residual.ravel()
    weights = huber_weights(rest, np.ones(rest.size, dtype=bool))
    rotation = datum_modes(measured, DATUM)[1].ravel()
    for direction in (model.shape.ravel(), rotation):
        size = np.sqrt((weights * direction) @ direction * (weights * rest) @ rest)
        assert abs((weights * direction) @ rest) < 1e-5 * size
    root, wear = np.sqrt(weights), measured.depth.ravel()
    amount = np.linalg.lstsq((root * rotation)[:, None], root * wear, rcond=None)[0]
    bare = weights @ (wear - rotation * amount) ** 2
    assert fit.explained == pytest.approx(1.0 - weights @ rest**2 / bare, rel=1e-6)
    np.testing.assert_allclose(fit.aligned - fit.predicted, fit.residual, atol=1e-15)
    dust = estimate(
        fit.residual,
        np.stack([fit.meshes * model.shape, rotation.reshape(model.p.shape)], axis=-1),
        weights.reshape(model.p.shape), *measured.places,
    )  # fmt: skip
    assert fit.log_error == pytest.approx(dust.errors[0], rel=1e-4)
    assert fit.effective_points == pytest.approx(dust.effective_points[0], rel=1e-4)


def test_meshes_of_a_linear_curve_are_weighted_least_squares(model):
    rng = np.random.default_rng(6)
    wear, modes = (model.shape + noise_of(model, "white", rng)).ravel(), rng.standard_normal((model.p.size, 2))
    root = rng.uniform(0.1, 3.0, model.p.size)
    every = root[:, None] * np.column_stack([model.shape.ravel(), modes])
    expected = np.linalg.lstsq(every, root * wear, rcond=None)[0][0]
    found, within = best_meshes(model.curve, wear, modes, root**2)
    assert within and found == pytest.approx(expected, rel=1e-6)


def test_meshes_beyond_the_curve_and_before_its_beginning_are_told(model):
    none, weights = np.zeros((model.p.size, 0)), np.ones(model.p.size)
    for meshes, end in ((-1.0, 2e-4), (3.0, 2.0)):
        assert best_meshes(model.curve, meshes * model.shape.ravel(), none, weights) == (pytest.approx(end), False)
    # steep at its end, where the best fit is within the last hundredth
    steep = WearCurve(np.array([0.0, 1.0, 1.99, 2.0]), np.outer([0.0, 1.0, 1.1, 10.0], model.shape.ravel()))
    found, within = best_meshes(steep, 1.5 * model.shape.ravel(), none, weights)
    assert 1.99 < found < 2.0 and not within


def test_a_rotation_that_takes_material_is_positive(model):
    """Points turned about the axis, z, against their normals: the surface lies deeper, as if it had worn."""
    measured = model.measured(0.0)
    points, normals = measured.flank.points(measured.face, measured.profile)
    names, modes = datum_modes(measured, DATUM)
    into = -np.einsum("pfi,pfi->pf", np.cross([0.0, 0.0, 1.0], points), normals)
    assert names == ("rotation",)  # a spur flank does not feel the other
    np.testing.assert_allclose(modes[..., 0], into, rtol=1e-12)


def test_places_that_were_not_measured_do_not_count(model):
    """The residual's root mean square is that of the points that are left, and 0 stands elsewhere."""
    error, inside = noise_of(model, "white", np.random.default_rng(7)), model.p < 0.5
    spoiled = np.where(inside, error, 1.0)
    curve = WearCurve(model.curve.meshes, model.curve.meshes[:, None] * model.shape[inside])
    fit = fit_part(curve, model.measured(spoiled, inside=inside), DATUM)
    assert fit.points == inside.sum() and not fit.residual[~inside].any()
    assert fit.residual_rms == pytest.approx(np.sqrt(np.mean(fit.residual[inside] ** 2)))


@pytest.mark.parametrize("half", [0.8, 1.4])
def test_a_coefficient_that_is_uncertain_by_a_factor_of_e_is_none(model, half):
    """Noise beside wear and datum, which does not move the fit: the error of ln N is inverse to the wear alone."""
    error = noise_of(model, "white", np.random.default_rng(8)).ravel()
    rotation = datum_modes(model.measured(0.0), DATUM)[1].ravel()
    both = np.column_stack([model.shape.ravel(), rotation])
    error = (error - both @ np.linalg.lstsq(both, error, rcond=None)[0]).reshape(model.p.shape)
    fit = fit_part(model.curve, model.measured(error), DATUM)
    meshes = fit.log_error * student.ppf(0.975, fit.freedom) / half
    if half < 1.0:
        found = fit_part(model.curve, model.measured(error, meshes), DATUM)
        assert found.meshes == pytest.approx(meshes, rel=1e-4)
        assert found.log_error == pytest.approx(fit.log_error / meshes, rel=1e-3)
    else:
        scatter = f"scatters by {1e3 * error.std():.2g} um"
        uncertain = f"uncertain by {100.0 * fit.log_error / meshes:.0f} %"
        with pytest.raises(SceneError, match=f"{scatter}.*{uncertain}"):
            fit_part(model.curve, model.measured(error, meshes), DATUM)


def test_wear_at_the_very_beginning_of_the_curve_says_nothing(model):
    with pytest.raises(SceneError, match="does not determine k"):
        fit_part(model.curve, model.measured(0.0, 3e-4), DATUM)


def test_robust_without_outliers_is_nearly_least_squares(model):
    error = noise_of(model, "white", np.random.default_rng(5))
    plain, robust = (fit_part(model.curve, model.measured(error), DATUM, robust=flag) for flag in (False, True))
    assert abs(np.log(robust.meshes / plain.meshes)) < plain.log_error
    assert robust.log_error == pytest.approx(plain.log_error, rel=0.35)


@pytest.mark.parametrize("meshes", [0.0, 0.002, -0.5])
def test_wear_below_the_noise_says_nothing(model, meshes):
    """As much of it as one draw of noise makes up, or the opposite of wear."""
    error = noise_of(model, "white", np.random.default_rng(8))
    with pytest.raises(SceneError, match="does not determine k"):
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

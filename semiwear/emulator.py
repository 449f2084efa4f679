"""Emulators: a Gaussian process in place of costly runs, with an error bound.

The process has a linear trend, a Matern 5/2 covariance with a length for each input, and a nugget for the scatter
between runs (Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, ch. 2 and 4; scikit-learn fits it
by maximum likelihood). Its error is found by leaving each run out (ibid., eq. 5.10 to 5.12): the stated error is the
smallest bound of the required fraction of those errors, counted so that the same fraction of new runs is within it
(conformal prediction, Vovk et al. 2005, Algorithmic Learning in a Random World; Barber et al. 2021, Ann. Stat. 49,
486-507). Covariance lengths are not fitted again for each run that is left out.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from importlib.util import find_spec
from math import ceil, sqrt

import numpy as np
from scipy.linalg import cho_solve
from scipy.spatial.distance import cdist

from semiwear.arrays import FloatArray
from semiwear.errors import MissingExtraError
from semiwear.untyped import Value

CONFIDENCE = 0.95
"""Fraction of new runs within the stated error."""

LEAST_RUNS = 19
"""Least number of runs for an error bound of 95 %."""

_SAME = 1e-10  # relative: a quantity that varies by less is constant


@dataclass(frozen=True)
class Emulator:
    """A number as a function of some inputs, fitted to runs by `emulator_of`.

    Attributes
    ----------
    error : float
        Stated error: a new run at inputs like those of the runs is within it with a probability of 95 %.
    deviation : float
        Standard deviation of the number over the runs.
    left_out : array (run,)
        Error at each run when it is left out.
    """

    error: float
    deviation: float
    left_out: FloatArray
    _process: _Process

    @property
    def relative_error(self) -> float:
        """The stated error over the standard deviation."""
        return self.error / self.deviation if self.deviation else 0.0

    def at(self, inputs: FloatArray) -> FloatArray:
        """The number at inputs (point, input): (point,)."""
        return self._process.at(inputs)


@dataclass(frozen=True)
class _Process:
    """Mean of a Gaussian process: constant + slopes . x + sum of weights times Matern 5/2 of scaled distances."""

    constant: float
    slopes: FloatArray
    lengths: FloatArray
    scaled: FloatArray
    weights: FloatArray

    def at(self, inputs: FloatArray) -> FloatArray:
        far = sqrt(5.0) * cdist(inputs / self.lengths, self.scaled)
        smooth = ((1.0 + far + far**2 / 3.0) * np.exp(-far)) @ self.weights
        return np.asarray(self.constant + inputs @ self.slopes + smooth)


def emulator_of(inputs: FloatArray, values: FloatArray) -> Emulator:
    """An emulator of runs.

    Parameters
    ----------
    inputs : array (run, input)
        Of the order of one.
    values : array (run,)
        `LEAST_RUNS` or more; with fewer the stated error is infinite.

    Raises
    ------
    MissingExtraError
        scikit-learn is missing; install the extra ``infer``.
    """
    mean, deviation = float(values.mean()), float(values.std())
    if deviation <= _SAME * max(float(np.abs(values).max()), 1e-300):
        fields = inputs.shape[1]
        constant = _Process(mean, np.zeros(fields), np.ones(fields), np.zeros((0, fields)), np.zeros(0))
        return Emulator(0.0, 0.0, np.zeros(values.size), constant)
    process = _fitted(inputs, (values - mean) / deviation)
    inverse = cho_solve((process.L_, True), np.eye(values.size))
    left_out = deviation * process.alpha_ / np.diag(inverse)
    fitted, weights = process.kernel_.get_params(), deviation * process.alpha_
    trend, lengths = fitted["k1__k1__k1__constant_value"], np.asarray(fitted["k1__k2__k2__length_scale"])
    constant = mean + trend * fitted["k1__k1__k2__sigma_0"] ** 2 * float(weights.sum())
    found = _Process(
        constant,
        trend * (weights @ inputs),
        lengths,
        inputs / lengths,
        fitted["k1__k2__k1__constant_value"] * weights,
    )
    return Emulator(kept_by(left_out), deviation, left_out, found)


def kept_by(errors: FloatArray) -> float:
    """Bound of the errors of new runs, from the errors of runs that were left out; infinite for too few runs."""
    rank = ceil((errors.size + 1) * CONFIDENCE)
    return float(np.sort(np.abs(errors))[rank - 1]) if rank <= errors.size else float("inf")


def require_emulator() -> None:
    """Raise `MissingExtraError` if the package that fits emulators is missing."""
    if find_spec("sklearn") is None:
        raise MissingExtraError("scikit-learn", "infer", "an emulator")


def _fitted(inputs: FloatArray, values: FloatArray) -> Value:
    try:
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Matern, WhiteKernel
    except ImportError as error:
        raise MissingExtraError("scikit-learn", "infer", "an emulator") from error
    lengths = np.ones(inputs.shape[1])
    trend = ConstantKernel(1.0, (1e-4, 1e2)) * DotProduct(1.0, (1e-2, 1e2))
    smooth = ConstantKernel(1.0, (1e-4, 1e3)) * Matern(lengths, (0.05, 50.0), nu=2.5)
    kernel = trend + smooth + WhiteKernel(1e-4, (1e-9, 1.0))
    process = GaussianProcessRegressor(kernel, alpha=1e-10, n_restarts_optimizer=1, random_state=0)
    with warnings.catch_warnings():  # a length at its bound means that an input hardly matters
        warnings.simplefilter("ignore", ConvergenceWarning)
        return process.fit(inputs, values)

r"""Frictionless contact as a small dense problem, with the rigid rotation as an explicit unknown.

Find forces F >= 0 and a rotation delta such that

.. math:: w = g + C F - \ell \, \delta \ge 0, \qquad F_j w_j = 0, \qquad \ell \cdot F = T

by a primal-dual active set: solve the equations with w = 0 on the active nodes and F = 0 on the others, then
let go of nodes that pull and take in nodes that penetrate (Hintermueller, Ito, Kunisch, SIAM J. Optim. 13 (2002) 865,
doi:10.1137/S1052623401383558). Since the torque is given, there is no rigid-body mode to hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from semiwear.errors import ConvergenceError, SceneError

__all__ = ["Complementarity", "solve_complementarity"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

AT_ONCE = 30
"""Sets that change freely. After that one node at a time, the worst one, which does not go round in circles."""


@dataclass(frozen=True)
class Complementarity:
    """Solution of `solve_complementarity`.

    Attributes
    ----------
    force : (n,) array [N]
    gap : (n,) array [mm]
        w, after loading.
    rotation : float [rad, or mm when the lever is 1]
    active : (n,) bool array
    iterations : int
        Active sets tried.
    equilibrium_residual : float
        Sum of force times lever, minus the torque, over the torque; without sign.
    """

    force: FloatArray
    gap: FloatArray
    rotation: float
    active: BoolArray
    iterations: int
    equilibrium_residual: float


def solve_complementarity(
    compliance: FloatArray,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    *,
    start: BoolArray | None = None,
    max_iterations: int = 500,
) -> Complementarity:
    """Forces and rotation for a torque.

    Parameters
    ----------
    compliance : (n, n) array [mm/N]
        Symmetric, positive definite.
    gap : (n,) array [mm]
        Before loading; may be negative.
    lever : (n,) array [mm]
        How much a unit rotation closes the gap; 1 for an approach instead of a rotation.
    torque : float [N mm, or N when the lever is 1]
    start : (n,) bool array, optional
        Active set to begin with, such as that of the last roll position.
    max_iterations : int
        Active sets tried.

    Raises
    ------
    SceneError
        A torque that is not positive, a gap, lever or compliance that is not finite, no node whose gap a rotation
        closes.
    ConvergenceError
        A compliance that is not positive definite, or no active set found.
    """
    _check(compliance, gap, lever, torque)
    active = np.zeros(len(gap), dtype=bool) if start is None else np.array(start, dtype=bool)
    scale = np.abs(gap).max()
    for iteration in range(1, max_iterations + 1):
        if not active.any():
            closing = np.flatnonzero(lever > 0.0)
            active[closing[np.argmin(gap[closing] / lever[closing])]] = True
        on = np.flatnonzero(active)
        try:
            factor = cho_factor(compliance[np.ix_(on, on)], lower=True, check_finite=False)
        except LinAlgError:
            raise ConvergenceError(
                f"contact: the compliance of {len(on)} active nodes is not positive definite; let the "
                "deformable body with the finer mesh be the slave"
            ) from None
        opposed, turned = cho_solve(factor, np.stack([gap[on], lever[on]], axis=1), check_finite=False).T
        rotation = (torque + lever[on] @ opposed) / (lever[on] @ turned)
        force = np.zeros(len(gap))
        force[on] = rotation * turned - opposed
        loaded = gap + compliance[:, on] @ force[on] - lever * rotation

        tolerance = 1e-12 * (scale + abs(rotation) * np.abs(lever).max())
        pulls = active & (force < 0.0)
        penetrates = ~active & (loaded < -tolerance)
        if not (pulls.any() or penetrates.any()):
            residual = abs(lever @ force - torque) / torque
            return Complementarity(force, loaded, float(rotation), active, iteration, float(residual))
        if iteration <= AT_ONCE:
            active = (active & ~pulls) | penetrates
        elif pulls.any():
            active[np.argmin(np.where(pulls, force, 0.0))] = False
        else:
            active[np.argmin(np.where(penetrates, loaded, 0.0))] = True
    raise ConvergenceError(
        f"contact: no active set found in {max_iterations} tries, {int(pulls.sum())} nodes pull and "
        f"{int(penetrates.sum())} penetrate by up to {-loaded.min():.3g} mm; refine the mesh where the gap "
        "has kinks, or raise max_iterations"
    )


def _check(compliance: FloatArray, gap: FloatArray, lever: FloatArray, torque: float) -> None:
    """Refuse what would give silent nonsense."""
    if not (np.isfinite(torque) and torque > 0.0):
        raise SceneError.of("torque", torque, "> 0", "the torque presses the flanks together; turn its sign")
    for name, values in (("gap", gap), ("lever", lever), ("compliance", compliance)):
        wrong = int(np.size(values) - np.isfinite(values).sum())
        if wrong:
            raise SceneError.of(
                name, f"{wrong} of {np.size(values)} not finite", "finite at every slave node",
                "leave nodes without an opposite flank point out of the slave surface",
            )  # fmt: skip
    if not (lever > 0.0).any():
        raise SceneError.of(
            "lever", float(np.max(lever, initial=0.0)), "> 0 at some node",
            "no rotation closes the gap: turn the sign of the lever, or choose the other flank",
        )  # fmt: skip

"""Contact of surface nodes under a torque, with the rotation as an unknown: the active set of `semiwear.contact`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem_reference.arrays import BoolArray, FloatArray
from semiwear.contact.active_set import ActiveSetStatus, solve_active_set
from semiwear.errors import ConvergenceError, SceneError


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
        Closing of the gap per unit rotation; 1 for an approach instead of a rotation.
    torque : float [N mm, or N when the lever is 1]
    start : (n,) bool array, optional
        Initial active set, for example that of the previous roll position.
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
    force, opened = np.zeros(len(gap)), np.zeros(len(gap))
    status, rotation, tried = solve_active_set(
        np.ascontiguousarray(compliance, float), np.asarray(gap, float), np.ascontiguousarray(lever, float),
        float(torque), 0.0, True, active, force, opened, max_iterations,
    )  # fmt: skip
    if status == ActiveSetStatus.NOT_POSITIVE_DEFINITE:
        raise ConvergenceError(
            f"contact: the compliance of {int(active.sum())} active nodes is not positive definite; let the "
            "deformable body with the finer mesh be the slave"
        )
    if status != ActiveSetStatus.CONVERGED:
        raise ConvergenceError(
            f"contact: no active set found in {max_iterations} tries, {int((force < 0.0).sum())} nodes pull and the "
            f"rest penetrate by up to {-opened.min():.3g} mm; refine the mesh where the gap has kinks, or raise "
            "max_iterations"
        )
    residual = abs(lever @ force - torque) / torque
    return Complementarity(force, opened, float(rotation), active, tried, float(residual))


def _check(compliance: FloatArray, gap: FloatArray, lever: FloatArray, torque: float) -> None:
    """Refuse invalid input that would give wrong results without an error."""
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

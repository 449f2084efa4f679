"""Load sharing on patches: forces on cells, and the rotation of the driving body, that balance a torque."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.complementarity import Complementarity, ComplementarityStatus
from semiwear.contact.patch_iteration import solve_in_windows
from semiwear.contact.patch_system import PatchSystem
from semiwear.contact.row_preconditioner import precondition, row_preconditioner
from semiwear.kernel_cache import inner_njit, njit

FORCE_TOLERANCE = 1e-9
"""Of forces on cells, in the L2 norm; smaller differences depend on the last bit of a gap."""
_LEAST = 1e-12  # of the deflection of one cell under the whole load: an approach that is zero
_FIRST_DROP = 0.03  # of the residual, before the active set is checked again
_FREE_SETS = 25  # active sets in which cells are released and added; then they are added one at a time
_SETTLED = 1e-7  # of the approach: residual of the cells that touch
_PIERCED = 1e-6  # of the approach: penetration from which a cell is added


@dataclass(frozen=True)
class SharedTorque:
    """Forces on the cells of a mesh position, with the errors of the contact conditions.

    Attributes
    ----------
    sharing : Complementarity
        Its `pressure` are forces [N], (rows, columns).
    rotation : float [rad]
        Of the driving body.
    balance : float
        Relative error of the torque.
    complementarity : float
        Greatest gap of cells under force, or penetration of the others, over the approach.
    """

    sharing: Complementarity
    rotation: float
    balance: float
    complementarity: float


def share_torque(
    system: PatchSystem,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    guess: FloatArray,
    max_iterations: int,
    tolerance: float = FORCE_TOLERANCE,
    again: bool = True,
) -> SharedTorque:
    """Forces on cells and rotation of the driving body that balance a torque.

    Parameters
    ----------
    system : PatchSystem
    gap : (rows, columns) array [mm]
        Infinite where nothing can touch.
    lever : (rows,) array [mm]
    torque : float [N mm]
    guess : (rows, columns) array [N]
        Forces to start from.
    max_iterations : int
        Convolutions.
    tolerance : float
        Relative L2 error of the forces.
    again : bool
        Whether active sets are tried where the iterations end short of the tolerance.
    """
    opening, start, touching = _from_first_touch(gap, lever, guess)
    sharing = solve_in_windows(system, opening, lever, torque, start, tolerance, max_iterations)
    if sharing.status is ComplementarityStatus.NOT_CONVERGED and again:
        sharing = _by_active_sets(system, opening, lever, torque, sharing, max_iterations)
    left, approach, borne = _left(opening, lever, sharing.approach, sharing.pressure, sharing.displacement)
    # a cell yields most to its own force
    least = _LEAST * float(system.coefficients[0, 0]) * torque / float(lever.max())
    return SharedTorque(
        sharing,
        touching + sharing.approach,
        balance=abs(borne / torque - 1.0),
        complementarity=left / max(approach, least),
    )


@njit(cache=True, error_model="numpy", nogil=True)
def _from_first_touch(gap, lever, guess):  # type: ignore[no-untyped-def]
    """Gaps from where the first cell touches, forces to start from, and the rotation up to there.

    A common gap of all cells would cost digits. If no force is guessed, the first cell bears one.
    """
    rows, columns = gap.shape
    opening, start, touching, any_force, first, at = np.empty(gap.shape), np.zeros(gap.shape), np.inf, False, 0, 0
    for r in range(rows):
        for c in range(columns):
            if gap[r, c] / lever[r] < touching:
                touching, first, at = gap[r, c] / lever[r], r, c
            if gap[r, c] < np.inf and guess[r, c] > 0.0:
                start[r, c], any_force = guess[r, c], True
    if not any_force:
        start[first, at] = 1.0
    for r in range(rows):
        for c in range(columns):
            opening[r, c] = gap[r, c] - touching * lever[r]
    return opening, start, touching


@inner_njit(cache=True, error_model="numpy", nogil=True)
def _left(gap, lever, rotation, force, displacement):  # type: ignore[no-untyped-def]
    """Greatest gap under pressed cells or penetration of others, greatest approach of a cell, and the torque."""
    worst, approach, borne = 0.0, 0.0, 0.0
    for r in range(gap.shape[0]):
        closing, total = rotation * lever[r], 0.0
        for c in range(gap.shape[1]):
            separation = gap[r, c] + displacement[r, c] - closing
            worst = max(worst, abs(separation) if force[r, c] > 0.0 else -separation)
            approach = max(approach, closing - gap[r, c])
            total += force[r, c]
        borne += lever[r] * total
    return worst, approach, borne


@inner_njit(cache=True, error_model="numpy")
def _change_contact(active, force, slack, tolerance, near, freely):  # type: ignore[no-untyped-def]  # noqa: C901
    """Release cells under tension, add penetrating ones `near` a row's deepest; returns the number changed."""
    rows, columns = active.shape
    changed, worst, worst_r, worst_c = 0, -tolerance, -1, -1
    for r in range(rows):
        at = -1
        for c in range(columns):
            if active[r, c]:
                if force[r, c] < 0.0:
                    active[r, c] = False
                    changed += 1
            elif slack[r, c] < -tolerance and (at < 0 or slack[r, c] < slack[r, at]):
                at = c
        if at < 0:
            continue
        if slack[r, at] < worst:
            worst, worst_r, worst_c = slack[r, at], r, at
        for c in range(max(at - near, 0), min(at + near + 1, columns)):
            if freely and not active[r, c] and slack[r, c] < -tolerance and force[r, c] >= 0.0:
                active[r, c] = True
                changed += 1
    if not freely and changed == 0 and worst_r >= 0:
        active[worst_r, worst_c] = True
        changed = 1
    return changed


def _by_active_sets(
    system: PatchSystem,
    gap: FloatArray,
    lever: FloatArray,
    torque: float,
    iterated: Complementarity,
    max_iterations: int,
) -> Complementarity:
    """Solution by active sets, each solved by conjugate gradients; `iterated` if that fails, too.

    In a wear step that is far too long, rows as a whole yield so much more than single cells that cutting off
    negative forces undoes the steps of projected gradients. Active sets, in which cells keep forces of either sign
    until the equations are nearly solved, still converge (Hintermueller, Ito & Kunisch 2002).
    """
    allowed, arms = np.isfinite(gap), lever[:, None]
    closed, near = np.where(allowed, gap, 0.0), max(gap.shape[1] // 8, 1)
    active = iterated.pressure > 0.0
    force, used, changed = iterated.pressure.copy(), iterated.iterations, 1
    kept, most, answer, z = row_preconditioner(*gap.shape), used + max_iterations, *np.empty((2, *gap.shape))
    for attempt in range(max_iterations):
        if not active.any():
            active.ravel()[np.argmin(gap / arms)] = True
        precondition(kept, system, np.where(active, arms, 0.0), active, answer)
        moment = float(lever @ answer.sum(axis=1))
        force = np.where(active, force, 0.0)
        force += answer * ((torque - float(lever @ force.sum(axis=1))) / moment)
        displacement, used, rotation, slip = system.apply(force), used + 1, 0.0, 0.0
        residual, direction, before = np.where(active, -(closed + displacement), 0.0), np.zeros_like(force), 0.0
        goal = np.inf
        while True:
            precondition(kept, system, residual, active, z)
            slip = -float(lever @ z.sum(axis=1)) / moment
            rotation += slip
            residual = residual + np.where(active, slip * arms, 0.0)
            z += slip * answer
            left, product = float(np.abs(residual).max()), float(np.vdot(residual, z))
            reference = float(np.max(rotation * arms - gap, where=allowed, initial=0.0))
            if not np.isfinite(goal):
                goal = max(_FIRST_DROP * left if changed else 0.0, _SETTLED * reference)
            if left <= goal or used >= most:
                break
            direction = z + (product / before if before > 0.0 else 0.0) * direction
            image, used, before = system.apply(direction), used + 1, product
            bend = float(np.vdot(direction, image))
            if bend <= 0.0:
                return replace(iterated, status=ComplementarityStatus.NOT_POSITIVE)
            length = float(np.vdot(direction, residual)) / bend
            force, displacement = force + length * direction, displacement + length * image
            residual = residual - np.where(active, length * image, 0.0)
        slack = gap + displacement - rotation * arms
        changed = _change_contact(active, force, slack, _PIERCED * reference, near, attempt < _FREE_SETS)
        if changed == 0 and left <= _SETTLED * reference:
            return replace(
                iterated, pressure=force, displacement=displacement, approach=rotation, load=torque,
                status=ComplementarityStatus.CONVERGED, iterations=used, error=0.0,
            )  # fmt: skip
        if used >= most:
            break
    return iterated

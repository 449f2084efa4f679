"""When failure modes fall below their required safeties, and which of them ends the life first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from semiwear.ratings.contact import WornStep
from semiwear.ratings.mode import FailureMode, Rated

__all__ = ["first_failure", "meshes_to_failure", "rating_arrays"]

FloatArray = NDArray[np.float64]


def meshes_to_failure(
    meshes: FloatArray, safety: FloatArray, required: float, damage: FloatArray | None
) -> FloatArray:
    """Engagements of one gear tooth at which each body first falls below its required safety.

    Linear between wear steps in Miner's sum where there is one, else in the safety.

    Parameters
    ----------
    meshes : (wear_step,) array
    safety : (wear_step, body) array
    required : float
    damage : (wear_step, body) array or None
        Miner's sum at the required safety.

    Returns
    -------
    (body,) array
        NaN where the run ends before.
    """
    found = np.full(safety.shape[1], np.nan)
    for body in range(found.size):
        below = np.flatnonzero(safety[:, body] < required)
        if below.size == 0:
            continue
        k = int(below[0])
        share = 1.0 if k == 0 else _share_of_step(safety[k - 1 : k + 1, body], required)
        if k and damage is not None and np.isfinite(damage[k, body]):
            before, after = damage[k - 1 : k + 1, body]
            share = (1.0 - before) / (after - before)
        found[body] = meshes[k] if k == 0 else meshes[k - 1] + share * (meshes[k] - meshes[k - 1])
    return found


def _share_of_step(safety: FloatArray, required: float) -> float:
    before, after = safety
    return float((before - required) / (before - after)) if np.isfinite(before) else 1.0


def first_failure(ends: FloatArray) -> tuple[int, int] | None:
    """Mode and body of the earliest of some ends, (mode, body); None where none is met."""
    if not np.isfinite(ends).any():
        return None
    mode, body = np.unravel_index(int(np.nanargmin(ends)), ends.shape)
    return int(mode), int(body)


def rating_arrays(
    modes: Mapping[str, FailureMode],
    rated: Mapping[str, Rated],
    steps: Sequence[WornStep],
    hours_per_mesh: float | None,
) -> dict[str, np.ndarray]:
    """Arrays of the group `/ratings`.

    Parameters
    ----------
    modes : mapping
    rated : mapping
        What each of them said of the wear steps.
    steps : sequence of WornStep
    hours_per_mesh : float or None
        None where the scene gives no speed.
    """
    meshes = np.array([step.meshes for step in steps])
    required = np.array([mode.required_safety for mode in modes.values()])
    told = list(rated.values())
    none = np.full_like(told[0].safety, np.nan)
    ends = np.stack(
        [meshes_to_failure(meshes, r.safety, need, r.damage) for r, need in zip(told, required, strict=True)]
    )
    first = first_failure(ends)
    arrays = {
        "required_safety": required,
        "safety": np.stack([r.safety for r in told]),
        "safety_height": np.stack([r.height for r in told]),
        "safety_face": np.stack([r.face for r in told]),
        "damage_sum": np.stack([none if r.damage is None else _finite(r.damage) for r in told]),
        "safety_on_flank": np.stack([r.flank.swapaxes(-1, -2) for r in told]),
        "meshes_to_failure": ends,
        "wear_step_of_failure": _steps_of(meshes, ends),
        "fails_first": np.array([int(first is not None and k == first[0]) for k in range(len(told))]),
    }
    if hours_per_mesh is not None:
        arrays |= {"hours": hours_per_mesh * meshes, "hours_to_failure": hours_per_mesh * ends}
    return arrays


def _finite(damage: FloatArray) -> FloatArray:
    return np.where(np.isfinite(damage), damage, np.nan)


def _steps_of(meshes: FloatArray, ends: FloatArray) -> FloatArray:
    """First wear step at which a failure has happened, (mode, body); -1 where none has."""
    steps = np.searchsorted(meshes, ends, side="left")
    return np.where(np.isfinite(ends), steps, -1)

"""Meshes at which safeties fall below those required, and the failure mode that comes first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.ratings.contact import WornStep
from semiwear.ratings.mode import FailureMode, Rated, life_exponent


def meshes_to_failure(meshes: FloatArray, safety: FloatArray, required: float) -> FloatArray:
    """Engagements of one gear tooth at which the safety of each body first falls below the required one.

    Linear between wear steps.

    Parameters
    ----------
    meshes : (wear_step,) array
    safety : (wear_step, body) array
    required : float

    Returns
    -------
    (body,) array
        NaN where the safety stays above it to the end of the run.
    """
    found = np.full(safety.shape[1], np.nan)
    for body in range(found.size):
        below = np.flatnonzero(safety[:, body] < required)
        if below.size == 0:
            continue
        k = int(below[0])
        before, after = safety[max(k - 1, 0), body], safety[k, body]
        share = (before - required) / (before - after) if np.isfinite(before) and k else 1.0
        found[body] = meshes[k] if k == 0 else meshes[k - 1] + share * (meshes[k] - meshes[k - 1])
    return found


def first_failure(ends: FloatArray) -> tuple[int, int] | None:
    """Indices (mode, body) of the earliest failure; None if there is none within the run."""
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
        Safeties of each mode.
    steps : sequence of WornStep
    hours_per_mesh : float or None
        None where the scene gives no speed.
    """
    meshes = np.array([step.meshes for step in steps])
    required = np.array([mode.required_safety for mode in modes.values()])
    results = list(rated.values())
    none = np.full_like(results[0].safety, np.nan)
    lives, exponents = [], []
    for own, need in zip(results, required, strict=True):
        life = partial(meshes_to_failure, meshes, own.safety)
        lives.append(life(need) if own.meshes is None else own.meshes)
        exponents.append(life_exponent(life, need) if own.exponent is None else own.exponent)
    ends = np.stack(lives)
    first = first_failure(ends)
    arrays = {
        "required_safety": required,
        "safety": np.stack([_finite(r.safety) for r in results]),
        "safety_height": np.stack([r.height for r in results]),
        "safety_face": np.stack([r.face for r in results]),
        "damage_sum": np.stack([none if r.damage is None else _finite(r.damage) for r in results]),
        "safety_on_flank": np.stack([_finite(r.flank).swapaxes(-1, -2) for r in results]),
        "meshes_to_failure": ends,
        "meshes_to_failure_exponent": np.stack(exponents),
        "wear_step_of_failure": _steps_of(meshes, ends),
        "fails_first": np.array([int(first is not None and k == first[0]) for k in range(len(results))]),
    }
    if hours_per_mesh is not None:
        arrays |= {"hours": hours_per_mesh * meshes, "hours_to_failure": hours_per_mesh * ends}
    return arrays


def _finite(values: FloatArray) -> FloatArray:
    """Values with NaN in place of infinity: safety of unstressed flanks, damage beyond static strength."""
    return np.where(np.isfinite(values), values, np.nan)


def _steps_of(meshes: FloatArray, ends: FloatArray) -> FloatArray:
    """First wear step at or after each failure, (mode, body); -1 where there is none."""
    steps = np.searchsorted(meshes, ends, side="left")
    return np.where(np.isfinite(ends), steps, -1)

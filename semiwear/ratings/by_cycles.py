"""Safeties of modes with cumulative damage, from stresses at the nodes of both flanks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.ratings.contact import WornStep
from semiwear.ratings.life_curve import LifeCurve
from semiwear.ratings.miner import StressHistory
from semiwear.ratings.mode import Rated, life_exponent, places_of


def rated_by_cycles(
    steps: Sequence[WornStep], stress: FloatArray, curves: Sequence[LifeCurve], required_safety: float
) -> Rated:
    """Safeties from Miner's sum, for stresses that act on every point once in each mesh.

    Parameters
    ----------
    steps : sequence of WornStep
    stress : (wear_step, load, body, face, node) array [MPa]
        NaN where there is none.
    curves : sequence of LifeCurve
        Of both bodies.
    required_safety : float
        Factor on the stresses for the damage sum and the life.
    """
    flanks, first = steps[0].flanks, steps[0].contacts
    meshes = np.array([step.meshes for step in steps])
    shares = np.array([contact.share for contact in first])
    histories = [
        StressHistory(flanks.cycles[body] * meshes, shares, stress[:, :, body].reshape(*stress.shape[:2], -1), curve)
        for body, curve in enumerate(curves)
    ]

    def lives(required: float) -> FloatArray:
        return np.array([history.life(required) for history in histories]) / flanks.cycles

    least = [history.least_safeties() for history in histories]
    height, face = places_of(flanks, np.stack([point for _, point in least], axis=1))
    return Rated(
        safety=np.stack([safety for safety, _ in least], axis=1),
        height=height,
        face=face,
        flank=np.stack([history.safeties() for history in histories]).reshape(flanks.profile.shape),
        damage=np.stack([history.damages(required_safety) for history in histories], axis=1),
        meshes=lives(required_safety),
        exponent=life_exponent(lives, required_safety),
    )

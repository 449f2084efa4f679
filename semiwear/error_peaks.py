"""Amplitude of the loaded transmission error, with its peaks between the solved roll positions.

Where a tooth pair begins or ceases to bear load, the transmission error has a kink, on spur gears mostly its least
value at the end of a steep fall. Evenly spaced roll positions may miss it: with 24 of them up to a third of the
amplitude of gears with tip relief, with 12 half of it. Steps of the mesh cycle in which the loaded pairs change, and
those beside the least and the greatest error, are therefore halved until they are narrow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.meshing.flank_pair import reference_lever
from semiwear.plan import Plan

_ROUNDING = 1e-9


def error_amplitude(physics: Plan, teeth: LoadedTeeth, state: LoadedState) -> float:
    """Peak to peak of the loaded transmission error over a mesh cycle of one wear state [arcsec].

    Parameters
    ----------
    physics : Plan
        With ``numerics.peak_positions``.
    teeth : LoadedTeeth
        Of that plan.
    state : LoadedState
    """
    positions = physics.scene.numerics.peak_positions
    assert positions is not None
    known = _MeshCycle.of(teeth, state)
    while (between := known.middles_of_steps((1.0 + _ROUNDING) / positions)).size:
        further = physics.teeth_between(teeth, between)
        loaded = further.load(state.wear, None, state.driving_wear)
        known = known.joined(_MeshCycle.of(further, loaded))
    return float(np.ptp(known.error))


@dataclass(frozen=True)
class _MeshCycle:
    """Increasing phases of a mesh cycle, (M,); transmission error, (M,) [arcsec]; pairs under load, (pairs, M)."""

    phase: FloatArray
    error: FloatArray
    loaded: BoolArray

    @classmethod
    def of(cls, teeth: LoadedTeeth, state: LoadedState) -> _MeshCycle:
        loaded = np.any(state.loads.force > 0.0, axis=1).reshape(teeth.rolls.pairs, -1)
        rotation = teeth.pair.arcsec_per_mm * reference_lever(teeth.pair) * state.loads.rotation
        return cls(teeth.rolls.phase, -rotation, loaded)

    def joined(self, other: _MeshCycle) -> _MeshCycle:
        phase = np.concatenate([self.phase, other.phase])
        order = np.argsort(phase)
        error = np.concatenate([self.error, other.error])
        return _MeshCycle(phase[order], error[order], np.concatenate([self.loaded, other.loaded], axis=1)[:, order])

    def middles_of_steps(self, limit: float) -> FloatArray:
        """Middles of steps wider than a limit in which the loaded pairs change or which end at an extreme."""
        width = np.diff(self.phase, append=self.phase[0] + 1.0)
        # at the end of the cycle a pair is where the pair before it was at the beginning
        next_cycle = np.append(self.loaded[1:, 0], False)[:, None]
        changes = (np.concatenate([self.loaded[:, 1:], next_cycle], axis=1) != self.loaded).any(axis=0)
        extreme = (self.error == self.error.min()) | (self.error == self.error.max())
        chosen = (changes | extreme | np.roll(extreme, -1)) & (width > limit)
        return np.asarray((self.phase + 0.5 * width)[chosen])

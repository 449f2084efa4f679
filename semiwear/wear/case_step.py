"""A load case within an implicit wear step: the wear that each force causes, and the loads that hold with it.

The rate of that wear, at first an estimate from the lines' motion, is corrected as the last step's was, and then by a
trial of the step: by the gap on the flanks that it would leave. Where the tip of the driving body digs in, the
estimate alone is a third too high.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.fidelity import SolveLoads
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.meshing.flank_grid import at_places
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.wear.mapping import WeightedLoads
from semiwear.wear.settling import Settling
from semiwear.wear.state import LoadCase
from semiwear.wear.swept_line import Sweep, own_wear
from semiwear.wear.worn import WearMultipliers, Worn

__all__ = ["CaseStep", "CoefficientFactor", "DepthFactor"]

CoefficientFactor = Callable[[LoadedTeeth, TeethLoads, LoadedState], FloatArray]
"""Factor on the wear coefficient in every slice, (roll, face), under loads on worn flanks."""
DepthFactor = Callable[[FloatArray], FloatArray]
"""Factor on the wear coefficient of the driven flank at its depth [mm], (face, profile)."""

_FACTOR_TOLERANCE = 1e-3  # of the greatest factor on the wear coefficient
_SMOOTH_FACTOR_TOLERANCE = 1e-10  # of the same, where results are to be smooth
_FACTOR_ITERATIONS = 120
_FACTOR_MISSED = 5e-2  # more than that after the last iteration: no wear can be told
_FORESEEN = 2  # changes of the factor before the own wear is corrected, where results are to be smooth
_FADES = 0.25  # of the elastic approach: a slice this much later still counts in part where results are smooth
_CORRECTION = (0.25, 2.0)  # of own wear, by a trial of the step: within it no step was unstable
_FELT = 1e-3  # of the greatest force on a slice: below it the gap says little of the wear that the force causes


class CaseStep:
    """One load case within an implicit step, whatever its length.

    The factor on the wear coefficient that spreads the wear is the one with which the loads were found: then the wear
    that a load causes is the gap under which the load was found, and no step is unstable.

    Parameters
    ----------
    coefficients : WearMultipliers
        Wear coefficient of each body [mm^2/N], times its meshes in one mesh of a driven tooth.
    case : LoadCase
    state : LoadedState
        Of the case at the start of the step.
    motion : Sweep
        Of the contact lines at the solved positions.
    factor : callable or None
        On the wear coefficients, where they depend on the contact.
    depth_factor : callable or None
        On the wear coefficient of the driven flank at its present depth.
    correction : (roll, face) array or None
        Of own wear, by the step before.
    """

    def __init__(
        self,
        coefficients: WearMultipliers,
        case: LoadCase,
        state: LoadedState,
        motion: Sweep,
        factor: CoefficientFactor | None,
        depth_factor: DepthFactor | None,
        correction: FloatArray | None = None,
    ):
        self.coefficients, self.case, self.state, self.motion = coefficients, case, state, motion
        self.factor_of, self.depth_factor = factor, depth_factor
        teeth = case.teeth
        rotation = np.tile(state.loads.rotation, teeth.rolls.pairs)
        self.distance = state.coarse.gap - rotation[:, None] * teeth.lines.lever_arm
        self.elastic = float(np.abs(teeth.problem.approach(state.loads)).mean())
        self.own, self.correction = np.zeros(0), correction
        self.factor: FloatArray | None = None if factor is None else self._factor_under(state.loads)
        self.law_residual = 0.0

    def prepare(self, meshes: float) -> None:
        """Own wear per mesh and force, for a step of about this length."""
        force = self.state.loads.force
        now = self._own(0.0)
        if self.factor is not None:
            now = now * self.factor
        # wear that the present loads would leave, where they are; elasticity spreads it when it is large
        depth = meshes * float(np.sum(now * force**2) / np.sum(force))
        self.own = self._own(depth / (1.0 + 0.5 * depth / self.elastic))

    @property
    def rate(self) -> FloatArray:
        """Own wear in one mesh per force on a slice, corrected [mm/N]."""
        return self.own if self.correction is None else self.own * self.correction

    def _own(self, growth: float) -> FloatArray:
        """Wear of both bodies in one mesh under the line itself, per force on a slice [mm/N]."""
        teeth, coarse, coefficients = self.case.teeth, self.state.coarse, self.coefficients
        arguments = (teeth.lines, self.motion, coarse, self.distance, growth)
        fades = _FADES * self.elastic if teeth.smooth else 0.0
        total = np.zeros(0)
        if coefficients.driven:
            total = coefficients.driven * own_wear(*arguments, DRIVEN, fades)
            if self.depth_factor is not None:
                total = total * at_places(teeth.grid.profile, self.depth_factor(self.state.wear), coarse.profile)
        if coefficients.driving:
            driving = coefficients.driving * own_wear(*arguments, DRIVING, fades)
            total = total + driving if total.size else driving
        return self.case.others * total

    def correct(self, worn: Worn, loads: TeethLoads, meshes: float) -> None:
        """Own wear of the lines as these worn flanks show it, after a step under these loads."""
        teeth, force = self.case.teeth, loads.force
        felt = force > _FELT * force.max()
        after = teeth.touch_solved(*worn, felt)
        before = self.state.touched  # as `after`, without what the loads press on edges
        said = meshes * force * (self.own if self.factor is None else self.own * self.factor)
        ratio = np.ones_like(said)
        felt &= said > 0.0
        ratio[felt] = (after.gap[felt] - before.gap[felt]) / said[felt]
        ratio = np.clip(ratio, *_CORRECTION)
        if teeth.smooth:
            # a slice that comes to be felt is so by and by
            ratio = 1.0 + (ratio - 1.0) * _share_felt(force, 1.0)
        self.correction = ratio

    def foreseen_loads(self, meshes: float, start: TeethLoads | None = None) -> TeethLoads:
        """Loads of a step to correct the own wear by: a law need not have settled under them."""
        if not self.case.teeth.smooth or self.factor is None or self.factor_of is None:
            return self.loads(meshes, None, start, roughly=True)
        loads = self._solve(meshes, None, start or self.state.loads)
        for _ in range(_FORESEEN):  # the same number in every run: results are smooth
            self.factor = self.factor + 0.5 * self._change(loads)
            loads = self._solve(meshes, None, loads)
        return loads

    def loads(
        self,
        meshes: float,
        positions: Sequence[int] | None,
        start: TeethLoads | None,
        *,
        roughly: bool = False,
    ) -> TeethLoads:
        """Loads that hold over the step; of less digits if roughly, unless results are to be smooth."""
        start, smooth = start or self.state.loads, self.case.teeth.smooth
        rough = None if smooth else self.case.teeth.fidelity.roughly
        asked = rough if roughly else None
        loads = self._solve(meshes, positions, start, asked)
        if self.factor is None or self.factor_of is None:
            return loads
        solved_by = asked
        tolerance = _SMOOTH_FACTOR_TOLERANCE if smooth else _FACTOR_TOLERANCE
        settling = Settling()
        for _ in range(_FACTOR_ITERATIONS):
            change = self._change(loads)
            greatest = float(self.factor.max())
            self.law_residual = float(np.abs(change).max() / greatest)
            if self.law_residual <= tolerance:
                break
            self.factor = settling.after(self.factor, change, tolerance * greatest)
            loads, solved_by = self._solve(meshes, positions, loads, rough), rough  # until the factor has settled
        else:
            if self.law_residual > _FACTOR_MISSED:
                raise ConvergenceError(
                    f"wear law and loads do not settle over a step of {meshes:.3g} meshes: after "
                    f"{_FACTOR_ITERATIONS} iterations the wear coefficient still changes by {self.law_residual:.1%} "
                    "of its greatest; take more numerics.wear_steps, or an effects.wear_law whose wear changes less "
                    "with the load"
                )
        return loads if solved_by is asked else self._solve(meshes, positions, loads)

    def _change(self, loads: TeethLoads) -> FloatArray:
        """By how much the factor that the loads make differs from the one under which they were found."""
        assert self.factor is not None
        return np.where(loads.force > 0.0, self._factor_under(loads) - self.factor, 0.0)

    def _factor_under(self, loads: TeethLoads) -> FloatArray:
        """Factor on the wear coefficient that the loads make; 1 where there is none."""
        assert self.factor_of is not None
        factor = self.factor_of(self.case.teeth, loads, self.state)
        # a power of the pressure is far from 1 under the least load: it, too, is felt by and by
        return 1.0 + (factor - 1.0) * _share_felt(loads.force, 0.0) if self.case.teeth.smooth else factor

    def _solve(
        self, meshes: float, positions: Sequence[int] | None, start: TeethLoads, solve: SolveLoads | None = None
    ) -> TeethLoads:
        rate = self.rate if self.factor is None else self.rate * self.factor
        teeth = self.case.teeth
        return (solve or teeth.fidelity.solve)(teeth.problem, self.state.coarse, start, meshes * rate, positions)

    def weighted(self, loads: TeethLoads) -> WeightedLoads:
        """Part of the case in the wear."""
        weight = self.case.share if self.factor is None else self.case.share * self.factor
        return WeightedLoads(self.case.teeth, loads, weight, self.case.share)


def _share_felt(force: FloatArray, least: float) -> FloatArray:
    """Part in which a slice counts where results are to be smooth: from `least` times the force that is felt on."""
    return np.asarray(np.clip(force / (_FELT * force.max()) - least, 0.0, 1.0))

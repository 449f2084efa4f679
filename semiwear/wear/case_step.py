"""A load case within an implicit wear step: its implicit wear compliance, and the loads solved with it.

The implicit wear compliance is the gap that one mesh wears under a line per force on it. It is estimated from the
motion of the lines, and corrected by the ratio of the gap on the predicted worn flanks to this estimate; the
correction is carried over to the next step. Where the tip of the driving body digs in, the estimate alone is a third
too high.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import log, sqrt

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

CoefficientFactor = Callable[[LoadedTeeth, TeethLoads, LoadedState], FloatArray]
"""Factor on the wear coefficient in every slice, (roll, face), under loads on worn flanks."""
DepthFactor = Callable[[FloatArray], FloatArray]
"""Factor on the wear coefficient of the driven flank at its depth [mm], (face, profile)."""

_FACTOR_TOLERANCE = 1e-3  # of the greatest factor on the wear coefficient
_SMOOTH_FACTOR_TOLERANCE = 1e-10  # of the same, where results are to be smooth
_FACTOR_ITERATIONS = 120
_MORE = 1.001  # forces, over which the tangent of a law is taken
_FACTOR_ERROR = 5e-2  # of the greatest factor: a greater change in the last iteration is an error
_PREDICTOR_UPDATES = 2  # of the factor before the compliance is corrected, where results are to be smooth
_FADES = 0.25  # of the elastic approach: distance over which later slices count in part where results are smooth
_CORRECTION = (0.25, 2.0)  # of the compliance; no step was unstable within these bounds
_LEAST_FORCE = 1e-3  # of the greatest force on a slice: below it the gap is no measure of the wear


class CaseStep:
    """One load case within an implicit step of any length.

    Wear is deposited with the same factor on the wear coefficient with which the loads were solved. The wear under a
    load is then the gap that the load was solved with, and no step is unstable.

    Parameters
    ----------
    coefficients : WearMultipliers
        Wear coefficient of each body [mm^2/N], times its meshes in one mesh of a driven tooth.
    case : LoadCase
    state : LoadedState
        Contact of the case at the start of the step.
    motion : Sweep
        Motion of the contact lines at the solved positions.
    factor : callable or None
        Factor on the wear coefficients where they depend on the contact.
    depth_factor : callable or None
        Factor on the wear coefficient of the driven flank by its wear depth.
    correction : (roll, face) array or None
        Correction of the compliance from the previous step.
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
        """Estimate the compliance per mesh for a step of about this length."""
        force = self.state.loads.force
        now = self._own(0.0)
        if self.factor is not None:
            now = now * self.factor
        # wear under the present loads, weighted by force; the elastic approach limits how far it grows
        depth = meshes * float(np.sum(now * force**2) / np.sum(force))
        self.own = self._own(depth / (1.0 + 0.5 * depth / self.elastic))

    @property
    def rate(self) -> FloatArray:
        """Implicit wear compliance of one mesh, corrected [mm/N]."""
        return self.own if self.correction is None else self.own * self.correction

    def _own(self, growth: float) -> FloatArray:
        """Wear of both bodies under the line itself in one mesh, per force on a slice [mm/N]."""
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
        """Correct the compliance by the gap on worn flanks, the result of a step under these loads."""
        teeth, force = self.case.teeth, loads.force
        loaded = force > _LEAST_FORCE * force.max()
        after = teeth.touch_solved(*worn, loaded)
        before = self.state.touched  # like `after` without pressed edges
        expected = meshes * force * (self.own if self.factor is None else self.own * self.factor)
        ratio = np.ones_like(expected)
        loaded &= expected > 0.0
        ratio[loaded] = (after.gap[loaded] - before.gap[loaded]) / expected[loaded]
        ratio = np.clip(ratio, *_CORRECTION)
        if teeth.smooth:  # no jump at the least force
            ratio = 1.0 + (ratio - 1.0) * _load_weight(force, 1.0)
        self.correction = ratio

    def predicted_loads(self, meshes: float, start: TeethLoads | None = None) -> TeethLoads:
        """Loads by which to correct the compliance; a wear law need not have converged under them."""
        if not self.case.teeth.smooth or self.factor is None or self.factor_of is None:
            return self.loads(meshes, None, start, roughly=True)
        loads = self._solve(meshes, None, start or self.state.loads)
        for _ in range(_PREDICTOR_UPDATES):  # the same number in every run keeps results smooth
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
        """Loads of the step; to fewer digits if `roughly`, unless results are to be smooth."""
        start, smooth = start or self.state.loads, self.case.teeth.smooth
        rough = None if smooth else self.case.teeth.fidelity.roughly
        final = rough if roughly else None
        loads = self._solve(meshes, positions, start, final)
        if self.factor is None or self.factor_of is None:
            return loads
        solved_by = final
        tolerance = _SMOOTH_FACTOR_TOLERANCE if smooth else _FACTOR_TOLERANCE
        settling = Settling()
        for _ in range(_FACTOR_ITERATIONS):
            change = self._change(loads)
            greatest = float(self.factor.max())
            self.law_residual = float(np.abs(change).max() / greatest)
            if self.law_residual <= tolerance:
                break
            tangent = partial(self._by_tangents, meshes, positions, loads, rough)
            self.factor = settling.after(self.factor, change, tolerance * greatest, tangent)
            loads, solved_by = self._solve(meshes, positions, loads, rough), rough  # until the factor has converged
        else:
            if self.law_residual > _FACTOR_ERROR:
                raise ConvergenceError(
                    f"wear law and loads do not settle over a step of {meshes:.3g} meshes: after "
                    f"{_FACTOR_ITERATIONS} iterations the wear coefficient still changes by {self.law_residual:.1%} "
                    "of its greatest; take more numerics.wear_steps, or an effects.wear_law whose wear changes less "
                    "with the load"
                )
        return loads if solved_by is final else self._solve(meshes, positions, loads)

    def _by_tangents(
        self, meshes: float, positions: Sequence[int] | None, loads: TeethLoads, solve: SolveLoads | None
    ) -> FloatArray:
        """Factor with the wear of every slice on its tangent over the load: a step of Newton's method.

        The wear N r f(F) F of N meshes under a force F has the tangent N r ((f + f') F - f' F_0) at F_0, with the
        change f' of the factor by the logarithm of the force: a greater wear compliance on a smaller gap. Wear that
        would fall with the force is taken to be constant.
        """
        assert self.factor is not None
        force, factor = loads.force, self._factor_under(loads)
        more = replace(loads, force=_MORE * force, half_width=sqrt(_MORE) * loads.half_width)
        slope = np.maximum((self._factor_under(more) - factor) / log(_MORE), -factor)
        wear, teeth = meshes * self.rate, self.case.teeth
        worn = self.state.coarse.nearer_by(wear * slope * force)
        found = (solve or teeth.fidelity.solve)(teeth.problem, worn, loads, wear * (factor + slope), positions)
        bears = (force > 0.0) & (found.force > 0.0)
        relative = np.divide(force, found.force, out=np.ones_like(force), where=bears)
        return np.maximum(np.where(bears, factor + slope * (1.0 - relative), self.factor), 0.0)

    def _change(self, loads: TeethLoads) -> FloatArray:
        """Factor under these loads less the factor with which they were solved."""
        assert self.factor is not None
        return np.where(loads.force > 0.0, self._factor_under(loads) - self.factor, 0.0)

    def _factor_under(self, loads: TeethLoads) -> FloatArray:
        """Factor on the wear coefficient under these loads; 1 where there is no load."""
        assert self.factor_of is not None
        factor = self.factor_of(self.case.teeth, loads, self.state)
        # a power of the pressure is far from 1 even under the least load: no jump there either
        return 1.0 + (factor - 1.0) * _load_weight(loads.force, 0.0) if self.case.teeth.smooth else factor

    def _solve(
        self, meshes: float, positions: Sequence[int] | None, start: TeethLoads, solve: SolveLoads | None = None
    ) -> TeethLoads:
        rate = self.rate if self.factor is None else self.rate * self.factor
        teeth = self.case.teeth
        return (solve or teeth.fidelity.solve)(teeth.problem, self.state.coarse, start, meshes * rate, positions)

    def weighted(self, loads: TeethLoads) -> WeightedLoads:
        """Loads with the weight of the case in the wear."""
        weight = self.case.share if self.factor is None else self.case.share * self.factor
        return WeightedLoads(self.case.teeth, loads, weight, self.case.share)


def _load_weight(force: FloatArray, least: float) -> FloatArray:
    """Weight of slices for smooth results: from 0 to 1 over one least force, beginning at `least` of them."""
    return np.asarray(np.clip(force / (_LEAST_FORCE * force.max()) - least, 0.0, 1.0))

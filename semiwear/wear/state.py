"""States between wear steps: worn flanks, their contact, and the loads they wear under."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from semiwear.arrays import FloatArray
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.meshing.flank_pair import BODIES, DRIVEN, DRIVING
from semiwear.wear.volume import WearVolume
from semiwear.wear.worn import Worn


@dataclass(frozen=True)
class LoadCase:
    """Teeth under one load of a spectrum.

    Attributes
    ----------
    share : float
        Share of the meshes.
    teeth : LoadedTeeth
    others : float
        Mean load of all cases over the load of this one.
    """

    share: float
    teeth: LoadedTeeth
    others: float = 1.0


@dataclass(frozen=True)
class WearState:
    """Worn flanks and their elastic contact.

    Attributes
    ----------
    meshes : float
        Engagements of one driven tooth so far.
    contact : LoadedState
    pace : float
        Meshes of the last step to a depth, over those that follow from the wear rate at its start.
    cases : tuple of LoadedState
        Contact in each load case; empty when there is only one, that of `contact`.
    error : float
        Estimated error of the steps so far, over the wear at the end of the run; 0 with fixed steps, whose error is
        not estimated.
    stride : tuple of float
        Suggested length of the next adaptive step, and meshes per length of the last one (`semiwear.wear.adaptive`);
        empty with fixed steps.
    volume : WearVolume
        Worn off so far by Archard's law.
    law_residual : float
        Change of the wear coefficient in the last iteration of the last step, over the greatest coefficient; 0 where
        no wear law makes it depend on loads.
    depth_ratio : float
        Wear depth of the control point in the last step, over the estimate from the mesh positions near the point.
    corrections : tuple of (roll, face) array
        Corrections of the implicit wear compliance in the last step, by load case (`semiwear.wear.case_step`); empty
        before the first step.
    """

    meshes: float
    contact: LoadedState
    pace: float = 1.0
    cases: tuple[LoadedState, ...] = ()
    error: float = 0.0
    stride: tuple[float, ...] = ()
    volume: WearVolume = field(default_factory=WearVolume.none)
    law_residual: float = 0.0
    depth_ratio: float = 1.0
    corrections: tuple[FloatArray, ...] = ()

    @property
    def wear(self) -> FloatArray:
        """Wear depth of the driven flank on the grid [mm]."""
        return self.contact.wear

    @property
    def worn(self) -> Worn:
        """Wear depths of both flanks [mm]."""
        return Worn(self.contact.wear, self.contact.driving_wear)

    @property
    def deepest(self) -> dict[str, float]:
        """Greatest wear depth of each body that wears [mm]."""
        depths = {BODIES[DRIVING]: self.worn.driving, BODIES[DRIVEN]: self.worn.driven}
        return {body: float(depth.max()) for body, depth in depths.items() if depth is not None and depth.any()}

    @property
    def loaded(self) -> tuple[LoadedState, ...]:
        """Contact in each load case."""
        return self.cases or (self.contact,)


@dataclass(frozen=True)
class Trial:
    """A step that is solved but not yet taken.

    Attributes
    ----------
    start : WearState
    meshes : float
        Its length.
    loads : sequence
        Loads of every load case over the step.
    worn : Worn
        Wear depths at its end [mm].
    pace, depth_ratio : float
        As in `WearState`.
    volume : WearVolume
        Worn off in the step.
    law_residual : float
        As in `WearState`.
    corrections : tuple of (roll, face) array
        As in `WearState`.
    theta : float
        Share of the step after which its loads were solved.
    """

    start: WearState
    meshes: float
    loads: Sequence[TeethLoads]
    worn: Worn
    pace: float
    volume: WearVolume = field(default_factory=WearVolume.none)
    law_residual: float = 0.0
    depth_ratio: float = 1.0
    corrections: tuple[FloatArray, ...] = ()
    theta: float = 1.0

    def scaled(self, share: float) -> Trial:
        """The step shortened or extended to a multiple of its length under the same loads: all wear is scaled."""
        return replace(
            self,
            meshes=share * self.meshes,
            worn=self.start.worn.towards(share, self.worn),
            pace=share * self.pace,
            volume=WearVolume(share * self.volume.driven, share * self.volume.on_edges),
        )


@dataclass(frozen=True)
class ControlPoint:
    """A point of a flank whose wear controls the steps.

    Attributes
    ----------
    face : float [mm]
    profile : (face,) array [mm]
        Profile coordinate of the point's height in each slice of its body.
    body : int
        `DRIVING` or `DRIVEN`.
    """

    face: float
    profile: FloatArray
    body: int = DRIVEN

    def wear(self, worn: Worn) -> FloatArray:
        """Wear depth of the flank on which the point lies, (face, profile) [mm]."""
        depth = worn.driven if self.body == DRIVEN else worn.driving
        assert depth is not None  # the scene's rules see to it that the body wears
        return depth

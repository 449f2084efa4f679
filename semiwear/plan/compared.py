"""Runs that are to be compared with one another: how those of nearly the same scene share what they stand on."""

from __future__ import annotations

from dataclasses import dataclass, replace

from semiwear.scene import GearPair, Material, Scene

__all__ = ["Compared", "Course", "Toothing"]


@dataclass(frozen=True)
class Toothing:
    """Gears and materials that prisms are found from.

    Attributes
    ----------
    gears : GearPair
    materials : tuple of Material
        Of pinion and gear.
    """

    gears: GearPair
    materials: tuple[Material, Material]

    @classmethod
    def of(cls, scene: Scene) -> Toothing:
        """That of a scene."""
        return cls(scene.gear_pair, (scene.material.pinion, scene.material.gear))

    def at_moduli(self, moduli: tuple[float, float]) -> Toothing:
        """The same with Young's moduli of pinion and gear [MPa]."""
        pinion, gear = (
            replace(own, youngs_modulus_MPa=modulus) for own, modulus in zip(self.materials, moduli, strict=True)
        )
        return Toothing(self.gears, (pinion, gear))


@dataclass(frozen=True)
class Course:
    """The course of prisms with a field that they depend on: a straight line through two values of it.

    Attributes
    ----------
    at, beside : Toothing
        In the scene with which others are compared, and with the field moved by a little.
    share : float
        Where on the line a run stands: 0 at the former, 1 at the latter.
    """

    at: Toothing
    beside: Toothing
    share: float


@dataclass(frozen=True)
class Compared:
    """A run to be compared with others: everything is iterated until results are smooth functions of the fields.

    Attributes
    ----------
    youngs_moduli : tuple of float [MPa]
        Of pinion and gear in the scene with which others are compared. Prisms are found at these: deflections are
        inverse to the modulus, so that none is found anew where that alone is changed.
    course : Course, optional
        Prisms are read there: none is found for the run itself.
    """

    youngs_moduli: tuple[float, float]
    course: Course | None = None

    @classmethod
    def with_runs_of(cls, scene: Scene) -> Compared:
        """To be compared with runs of this scene."""
        return cls((scene.material.pinion.youngs_modulus_MPa, scene.material.gear.youngs_modulus_MPa))

    def along(self, at: Scene, beside: Scene, share: float) -> Compared:
        """The same with prisms on the straight line through those of two scenes, if they are not the same ones."""
        ends = [Toothing.of(scene).at_moduli(self.youngs_moduli) for scene in (at, beside)]
        return self if ends[0] == ends[1] else replace(self, course=Course(ends[0], ends[1], share))

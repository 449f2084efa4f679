"""Runs of nearly the same scene that are compared with one another, and the preparation that they share."""

from __future__ import annotations

from dataclasses import dataclass, replace

from semiwear.scene import GearPair, Material, Scene


@dataclass(frozen=True)
class Toothing:
    """Gears and materials, on which the prisms depend.

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
        """Gears and materials of a scene."""
        return cls(scene.gear_pair, (scene.material.pinion, scene.material.gear))

    def at_moduli(self, moduli: tuple[float, float]) -> Toothing:
        """The same with Young's moduli of pinion and gear [MPa]."""
        pinion, gear = (
            replace(own, youngs_modulus_MPa=modulus) for own, modulus in zip(self.materials, moduli, strict=True)
        )
        return Toothing(self.gears, (pinion, gear))


@dataclass(frozen=True)
class Course:
    """Prisms as a linear function of a field, through two of its values.

    Attributes
    ----------
    at, beside : Toothing
        Of the reference scene, and with the field changed a little.
    share : float
        Position of a run on the line: 0 at the former, 1 at the latter.
    """

    at: Toothing
    beside: Toothing
    share: float


@dataclass(frozen=True)
class Compared:
    """A run that is compared with others, iterated so far that results are smooth functions of the fields.

    Attributes
    ----------
    youngs_moduli : tuple of float [MPa]
        Of pinion and gear in the reference scene. Prisms are found for these; deflections are inversely proportional
        to the modulus, so that a change of the modulus alone needs no new prisms.
    course : Course, optional
        Prisms are interpolated on it instead of found for the run itself.
    """

    youngs_moduli: tuple[float, float]
    course: Course | None = None

    @classmethod
    def with_runs_of(cls, scene: Scene) -> Compared:
        """For comparison with runs of this scene."""
        return cls((scene.material.pinion.youngs_modulus_MPa, scene.material.gear.youngs_modulus_MPa))

    def along(self, at: Scene, beside: Scene, share: float) -> Compared:
        """The same with prisms on the line through those of two scenes, unless they are equal."""
        ends = [Toothing.of(scene).at_moduli(self.youngs_moduli) for scene in (at, beside)]
        return self if ends[0] == ends[1] else replace(self, course=Course(ends[0], ends[1], share))

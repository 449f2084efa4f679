"""Runs that are to be compared with one another: how those of nearly the same scene share what they stand on."""

from __future__ import annotations

from dataclasses import dataclass

from semiwear.scene import Scene

__all__ = ["Compared"]


@dataclass(frozen=True)
class Compared:
    """A run to be compared with others: everything is iterated until results are smooth functions of the fields.

    Attributes
    ----------
    youngs_moduli : tuple of float [MPa]
        Of pinion and gear in the scene with which others are compared. Prisms are found at these: deflections are
        inverse to the modulus, so that none is found anew where that alone is changed.
    """

    youngs_moduli: tuple[float, float]

    @classmethod
    def with_runs_of(cls, scene: Scene) -> Compared:
        """To be compared with runs of this scene."""
        return cls((scene.material.pinion.youngs_modulus_MPa, scene.material.gear.youngs_modulus_MPa))

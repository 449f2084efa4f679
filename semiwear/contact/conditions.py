"""Conditions in the loaded contact lines: input of friction, oil film, flash temperature and wear laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.closed_forms.hertz import line_contact_half_width, line_contact_pressure


@dataclass(frozen=True, eq=False)
class ContactConditions:
    """Load and motion of every slice of the contact lines; arrays are (roll, face) unless stated otherwise.

    A slice without load has `line_load` 0. Its other values must be finite and are not used.

    Attributes
    ----------
    line_load : array [N/mm]
    half_width : array [mm]
        Hertz half-width across the line.
    curvature : array [1/mm]
        Relative curvature across the line.
    pressure : array [MPa]
        Greatest Hertz pressure.
    surface_speed : (2, roll, face) array [mm/s]
        Signed velocities of the driving and the driven surface through the contact, across the line and relative
        to the contact: both have one sign where the surfaces roll.
    sliding_speed : array [mm/s]
        Magnitude of the sliding velocity, its component along the line included.
    roughness_ratio : array, optional
        Roughness of the flanks over that when new.
    """

    line_load: FloatArray
    half_width: FloatArray
    curvature: FloatArray
    pressure: FloatArray
    surface_speed: FloatArray
    sliding_speed: FloatArray
    roughness_ratio: FloatArray | float = 1.0

    @classmethod
    def hertz(cls, line_load: FloatArray, curvature: FloatArray, surface_speed: FloatArray, modulus: float) -> Self:
        """Conditions of Hertz line contacts whose surfaces slide across the line alone.

        Parameters
        ----------
        line_load : (roll, face) array [N/mm]
        curvature : (roll, face) array [1/mm]
        surface_speed : (2, roll, face) array [mm/s]
        modulus : float [MPa]
            Effective modulus E*.
        """
        return cls(
            line_load=line_load,
            half_width=line_contact_half_width(line_load, curvature, modulus),
            curvature=curvature,
            pressure=line_contact_pressure(line_load, curvature, modulus),
            surface_speed=surface_speed,
            sliding_speed=np.abs(surface_speed[0] - surface_speed[1]),
        )

    @property
    def loaded(self) -> BoolArray:
        """Slices that carry load."""
        return self.line_load > 0.0

    @property
    def sum_speed(self) -> FloatArray:
        """Magnitude of the sum velocity |v1 + v2| across the line [mm/s]."""
        return np.asarray(np.abs(self.surface_speed[0] + self.surface_speed[1]))

    @property
    def entraining_speed(self) -> FloatArray:
        """Magnitude of the entraining velocity |v1 + v2|/2 across the line [mm/s]."""
        return 0.5 * self.sum_speed

    @property
    def sliding_direction(self) -> FloatArray:
        """Sign of v1 - v2 across the line: +1 where the driving surface is the faster one."""
        return np.asarray(np.sign(self.surface_speed[0] - self.surface_speed[1]))

    def where_loaded(self, values: FloatArray) -> FloatArray:
        """Values of the loaded slices and 1 elsewhere, so that any power of them is finite."""
        return np.where(self.loaded, values, 1.0)

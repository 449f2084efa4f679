"""Elastohydrodynamic film thickness of a lubricated line contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions


def dowson_higginson_minimum(speed: FloatArray, material: float, load: FloatArray) -> FloatArray:
    """Least film of a line contact, H = h/R = 2.65 G^0.54 U^0.70 W^-0.13.

    Dowson and Higginson (1966), *Elasto-hydrodynamic Lubrication*, with the exponents of Dowson (1968), Proc. Instn
    Mech. Engrs 182 (3A), 151-167.

    Parameters
    ----------
    speed : array
        U = eta u/(E' R), with the entraining velocity u = (v1 + v2)/2 and E' = 2 E*.
    material : float
        G = alpha E'.
    load : array
        W = q/(E' R), above 0.
    """
    film: FloatArray = 2.65 * material**0.54 * speed**0.70 * load**-0.13
    return film


def dowson_toyoda_central(speed: FloatArray, material: float, load: FloatArray) -> FloatArray:
    """Film in the middle of a line contact, H = 3.06 G^0.56 U^0.69 W^-0.10; arguments as for the least film.

    Dowson and Toyoda (1979), Proc. 5th Leeds-Lyon Symposium on Tribology, 60-65.
    """
    film: FloatArray = 3.06 * material**0.56 * speed**0.69 * load**-0.10
    return film


def hamrock_dowson_minimum(speed: FloatArray, material: float, load: FloatArray, ellipticity: float) -> FloatArray:
    """Least film of an elliptic contact, H = h/R_x = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k)).

    Hamrock and Dowson (1977), J. Lubr. Technol. 99, 264-276. Fitted for k of 1 to 8.

    Parameters
    ----------
    speed : array
        U = eta u/(E' R_x), with the entraining velocity u = (v1 + v2)/2 and E' = 2 E*.
    material : float
        G = alpha E'.
    load : array
        W = F/(E' R_x^2), above 0, with the force F.
    ellipticity : float
        k = a/b, the axis across the motion over the axis along it.
    """
    film: FloatArray = 3.63 * speed**0.68 * material**0.49 * load**-0.073 * (1.0 - np.exp(-0.68 * ellipticity))
    return film


def hamrock_dowson_central(speed: FloatArray, material: float, load: FloatArray, ellipticity: float) -> FloatArray:
    """Film in the middle of an elliptic contact, H = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k)).

    Hamrock and Dowson (1977), J. Lubr. Technol. 99, 264-276; arguments as for the least film.
    """
    film: FloatArray = 2.69 * speed**0.67 * material**0.53 * load**-0.067 * (1.0 - 0.61 * np.exp(-0.73 * ellipticity))
    return film


@dataclass(frozen=True)
class FilmThickness:
    """Isothermal, fully flooded oil film between smooth surfaces.

    ``"dowson_higginson"`` takes a slice as a line contact under its line load q.

    ``"hamrock_dowson"`` takes it as the middle of an ellipse with the slice's half-width b, which carries the force
    F = (4/3) k b q where its greatest line load is q. Their formula depends on k through that force even for long
    ellipses, like k^-0.073, and was fitted up to k = 8, which is used unless another is given.

    Standing or counter-rotating surfaces (no entraining velocity) have no film. Inlet heating and starvation thin the
    film of fast contacts further.

    Attributes
    ----------
    model : {"dowson_higginson", "hamrock_dowson"}
    viscosity_mPas : float
        Dynamic viscosity at the temperature of the teeth and ambient pressure.
    pressure_viscosity_per_GPa : float
        alpha, 15 to 25 for mineral oils.
    roughness_um : float
        Root mean square of both surfaces together, sqrt(Rq1^2 + Rq2^2).
    effective_modulus : float [MPa]
        E*, half the E' of the formulas.
    ellipticity : float
        Of the Hamrock and Dowson contact.
    """

    model: Literal["dowson_higginson", "hamrock_dowson"]
    viscosity_mPas: float
    pressure_viscosity_per_GPa: float
    roughness_um: float
    effective_modulus: float
    ellipticity: float = 8.0

    def minimum(self, conditions: ContactConditions) -> FloatArray:
        """Least film thickness [um], (roll, face); 0 where there is no load."""
        speed, material, load = self._groups(conditions)
        if self.model == "dowson_higginson":
            return self._thickness(conditions, dowson_higginson_minimum(speed, material, load))
        return self._thickness(conditions, hamrock_dowson_minimum(speed, material, load, self.ellipticity))

    def central(self, conditions: ContactConditions) -> FloatArray:
        """Film thickness in the middle of the contact [um], (roll, face); 0 where there is no load."""
        speed, material, load = self._groups(conditions)
        if self.model == "dowson_higginson":
            return self._thickness(conditions, dowson_toyoda_central(speed, material, load))
        return self._thickness(conditions, hamrock_dowson_central(speed, material, load, self.ellipticity))

    def lambda_ratio(self, conditions: ContactConditions) -> FloatArray:
        """Least film thickness over the roughness of both surfaces, (roll, face)."""
        return np.asarray(self.minimum(conditions) / (self.roughness_um * conditions.roughness_ratio))

    def _groups(self, conditions: ContactConditions) -> tuple[FloatArray, float, FloatArray]:
        """Dimensionless speed U, material G and load W; U and W are 1 where there is no load."""
        modulus = 2.0 * self.effective_modulus
        speed = 1e-9 * self.viscosity_mPas * conditions.entraining_speed * conditions.curvature / modulus
        load = conditions.line_load * conditions.curvature / modulus
        if self.model == "hamrock_dowson":
            load = load * 4.0 / 3.0 * self.ellipticity * conditions.half_width * conditions.curvature
        material = 1e-3 * self.pressure_viscosity_per_GPa * modulus
        return conditions.where_loaded(speed), material, conditions.where_loaded(load)

    @staticmethod
    def _thickness(conditions: ContactConditions, film: FloatArray) -> FloatArray:
        return np.where(conditions.loaded, 1e3 * film / conditions.where_loaded(conditions.curvature), 0.0)

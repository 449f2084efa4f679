"""Named sets of data with their sources: materials, wear coefficients and oils, as TOML files in `named`.

They are used only if a scene names them, never as defaults.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from math import log10

from semiwear.untyped import Table

MATERIALS, WEAR, OILS = "materials", "wear", "oils"
"""Kinds of named data."""

_KELVIN = 273.15
_DENSITY_AT = 15.0  # degrees Celsius, temperature of the oils' densities


@cache
def named_sets(kind: str) -> dict[str, Table]:
    """Sets of a kind by name, in the order of their file."""
    text = resources.files(__package__).joinpath("named", f"{kind}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def named_set(kind: str, name: object) -> Table:
    """A set by name; empty for unknown names."""
    return named_sets(kind).get(name, {}) if isinstance(name, str) else {}


def oil_at(oil: Table, temperature: float) -> dict[str, float]:
    """Viscosity and pressure-viscosity coefficient of an oil, by the names of a scene's fields.

    lg lg(v + 0.7) = m - n lg T gives the kinematic viscosity (ASTM D341), s v^t the pressure-viscosity coefficient
    (Gold et al. 2001).

    Parameters
    ----------
    oil : mapping
        A set of `named_sets` of oils.
    temperature : float
        In degrees Celsius.
    """
    kinematic = 10.0**10.0 ** (oil["astm_m"] - oil["astm_n"] * log10(temperature + _KELVIN)) - 0.7
    density = oil["density_kg_per_m3"] * (1.0 + oil["expansion_per_K"] * (temperature - _DENSITY_AT))
    return {
        "viscosity_mPas": float(f"{1e-3 * kinematic * density:.4g}"),
        "pressure_viscosity_per_GPa": float(f"{oil['piezoviscosity_s'] * kinematic ** oil['piezoviscosity_t']:.4g}"),
    }

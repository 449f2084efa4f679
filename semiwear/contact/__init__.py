"""Contact of elastic bodies: where they touch, and under what pressure.

Textbook functions on plain arrays, which need no scene: `solve_half_space` for any gap, the closed forms of Hertz,
and the kernels of the half-space.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from semiwear.closed_forms import (
        EllipticContact,
        effective_modulus,
        elliptic_contact,
        line_contact_half_width,
        line_contact_pressure,
        love_coefficients,
        rectangle_stress,
        stripe_kernel,
    )
    from semiwear.contact.certificate import ContactCertificate
    from semiwear.contact.half_space import ContactStatus, HalfSpaceContact, extrapolate, solve_half_space

__all__ = [
    "ContactCertificate",
    "ContactStatus",
    "EllipticContact",
    "HalfSpaceContact",
    "effective_modulus",
    "elliptic_contact",
    "extrapolate",
    "line_contact_half_width",
    "line_contact_pressure",
    "love_coefficients",
    "rectangle_stress",
    "solve_half_space",
    "stripe_kernel",
]

_HALF_SPACE = ("ContactStatus", "HalfSpaceContact", "extrapolate", "solve_half_space")


def __getattr__(name: str) -> object:
    """Public names, imported on first use: gears do not need the half-space solver."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = "closed_forms"
    if name in _HALF_SPACE:
        module = "contact.half_space"
    elif name == "ContactCertificate":
        module = "contact.certificate"
    found = getattr(import_module(f"semiwear.{module}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)

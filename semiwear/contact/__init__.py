"""Who touches, and with what pressure.

Textbook functions on plain arrays, which need no scene: `solve_half_space` for any gap, the closed forms of Hertz,
and the kernels of the half-space.
"""

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

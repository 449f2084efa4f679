"""Closed forms of contact mechanics: arrays in, arrays out, each with its range and source."""

from semiwear.closed_forms.hertz import (
    EllipticContact,
    effective_modulus,
    elliptic_contact,
    line_contact_half_width,
    line_contact_pressure,
)
from semiwear.closed_forms.love import love_coefficients
from semiwear.closed_forms.love_stress import corner_stress, point_stress, rectangle_stress
from semiwear.closed_forms.stripe import stripe_kernel

__all__ = [
    "EllipticContact",
    "corner_stress",
    "effective_modulus",
    "elliptic_contact",
    "line_contact_half_width",
    "line_contact_pressure",
    "love_coefficients",
    "point_stress",
    "rectangle_stress",
    "stripe_kernel",
]

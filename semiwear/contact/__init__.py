"""Who touches, and with what pressure."""

from semiwear.contact.half_space import (
    ContactCertificate,
    ContactStatus,
    HalfSpaceContact,
    extrapolate,
    solve_half_space,
)

__all__ = ["ContactCertificate", "ContactStatus", "HalfSpaceContact", "extrapolate", "solve_half_space"]

"""Who touches, and with what pressure."""

from semiwear.contact.certificate import ContactCertificate
from semiwear.contact.half_space import ContactStatus, HalfSpaceContact, extrapolate, solve_half_space

__all__ = ["ContactCertificate", "ContactStatus", "HalfSpaceContact", "extrapolate", "solve_half_space"]

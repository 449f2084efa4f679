"""Measured flanks: tooth flanks with small deviations, displaced as on a measuring machine."""

import numpy as np
from hypothesis import strategies as st

from semiwear.measured.nominal import NominalFlank
from semiwear.measured.rigid import Displacement


def displacements():
    """Rotations about the axis by any angle, and shifts along it by up to 0.05 mm."""
    return st.builds(
        Displacement.about_axis,
        st.floats(-3.1, 3.1),
        st.floats(-0.05, 0.05),
    )


@st.composite
def gentle_deviations(draw):
    """A function of fractions (profile, face) in mm: waves of up to 10 um."""
    amount = draw(st.floats(0.0, 1e-2))
    across, along = draw(st.floats(0.0, 4.0)), draw(st.floats(0.0, 4.0))
    phase = draw(st.floats(0.0, 6.0))
    return lambda p, f: amount * np.cos(across * p + along * f + phase)


def grid_on(flank: NominalFlank, rows: int, columns: int, margin: float = 0.04):
    """Face and profile coordinates of an even grid within the flank, with the fractions (profile, face)."""
    p = np.linspace(margin, 1.0 - margin, rows)[:, None] + np.zeros(columns)
    f = np.linspace(margin, 1.0 - margin, columns) + np.zeros((rows, 1))
    face, profile = flank.places(f, p)
    return face, profile, p, f


def displaced(flank: NominalFlank, face, profile, deviation, displacement: Displacement):
    """Points of a flank with deviations [mm] along its normals, displaced."""
    points, normals = flank.points(face, profile)
    return displacement.apply(points + np.asarray(deviation)[..., None] * normals)

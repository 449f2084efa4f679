"""Stress below a uniformly loaded rectangle on an elastic half-space (Love 1929).

A normal pressure p on the plane z = 0, with z into the body, gives by Boussinesq's potentials
V = integral of p/rho and chi = integral of p ln(rho + z) (Love 1929; Johnson, *Contact Mechanics*, 1985, sec. 3.2)

    2 pi sigma_x = 2 nu V_z - z V_xx - (1 - 2 nu) chi_xx      2 pi tau_xy = -z V_xy - (1 - 2 nu) chi_xy
    2 pi sigma_z = V_z - z V_zz                               2 pi tau_xz = -z V_xz

and sigma_y, tau_yz with x and y changed over. Over a rectangle each is the difference, corner by corner, of a
function of the vector from corner to point. Tension is positive.
"""

from __future__ import annotations

from math import pi

import numpy as np

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray

COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def corner_stress(x: FloatArray, y: FloatArray, depth: float, poissons_ratio: float) -> FloatArray:
    """Stress of a unit pressure as a function of the vector from a corner, to be differenced over the corners.

    Every antiderivative is taken odd or even in x and in y: the textbook's ln(rho + x) and 1/(rho + x), which lose
    their digits at negative x, differ from these by functions of one coordinate, which drop out of the differences.

    Parameters
    ----------
    x, y : arrays that broadcast [mm]
        From corner to point; not 0 at depth 0.
    depth : float [mm]
        0 or more.
    poissons_ratio : float

    Returns
    -------
    (6, ...) array [MPa per MPa]
        In the order of `COMPONENTS`.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    z, z2, incompressible = depth, depth**2, 1.0 - 2.0 * poissons_ratio
    x2, y2 = x**2, y**2
    plane = x2 + y2
    rho = np.sqrt(plane + z2)
    product = x * y
    solid_angle = np.arctan2(product, z * rho)  # -V_z
    # chi_xx = atan(y/x) - atan(z y/(x rho)), its two terms put together since they cancel as z grows
    chi_xx = np.arctan2(product * plane / (rho + z), x2 * rho + z * y2)
    along_x, along_y = 1.0 / (rho * (x2 + z2)), 1.0 / (rho * (y2 + z2))
    bend_x, bend_y = z * product * along_x, z * product * along_y  # -z V_xx, -z V_yy

    stress = np.empty((6, *rho.shape))
    stress[0] = bend_x - 2.0 * poissons_ratio * solid_angle - incompressible * chi_xx
    stress[1] = bend_y - 2.0 * poissons_ratio * solid_angle - incompressible * (solid_angle - chi_xx)
    stress[2] = -solid_angle - bend_x - bend_y
    stress[3] = -z / rho - incompressible * np.log(rho + z)
    stress[4] = z2 * y * along_x
    stress[5] = z2 * x * along_y
    stress /= 2.0 * pi
    return stress


def rectangle_stress(
    columns: int, rows: int, *, cell: tuple[float, float], depth: float, poissons_ratio: float
) -> FloatArray:
    """Stress in a half-space under a unit pressure on one cell, below the middles of the cells at and beyond it.

    Parameters
    ----------
    columns, rows : int
        Cells in x and in y, the loaded one among them.
    cell : (float, float) [mm]
        Sides dx, dy of a cell.
    depth : float [mm]
        0 or more.
    poissons_ratio : float
        Above -1, up to 0.5.

    Returns
    -------
    (6, columns, rows) array [MPa per MPa]
        Components xx, yy, zz, xy, xz, yz at (i dx, j dy), z pointing into the body, tension positive; the loaded cell
        is [:, 0, 0].

    Raises
    ------
    ValueError
        A number is out of its range.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929); Johnson, *Contact Mechanics* (1985), sec. 3.2.
    """
    require_range("the number of cells", (columns, rows), least=1)
    require_range("the sides of a cell", cell, "mm", above=0.0)
    require_range("the depth", depth, "mm", least=0.0)
    require_range("Poisson's ratio", poissons_ratio, above=-1.0, most=0.5)
    x = (np.arange(columns + 1, dtype=np.float64) - 0.5) * cell[0]
    y = (np.arange(rows + 1, dtype=np.float64) - 0.5) * cell[1]
    corners = corner_stress(x[:, None], y, depth, poissons_ratio)
    return np.diff(np.diff(corners, axis=1), axis=2)


def point_stress(
    pressure: FloatArray, place: tuple[int, int], *, cell: tuple[float, float], depth: float, poissons_ratio: float
) -> FloatArray:
    """Stress below the middle of one cell, summed over all corners.

    Parameters
    ----------
    pressure : (nx, ny) array [MPa]
    place : (ix, iy)
        The cell.
    cell : (dx, dy) [mm]
    depth : float [mm]
    poissons_ratio : float

    Returns
    -------
    (6,) array [MPa]
        In the order of `COMPONENTS`.
    """
    x = (place[0] + 0.5 - np.arange(pressure.shape[0] + 1, dtype=np.float64)) * cell[0]
    y = (place[1] + 0.5 - np.arange(pressure.shape[1] + 1, dtype=np.float64)) * cell[1]
    # cells that share a corner count it with the difference of their pressures
    steps = np.diff(np.diff(np.pad(pressure, 1), axis=0), axis=1)
    return np.tensordot(corner_stress(x[:, None], y, depth, poissons_ratio), steps, axes=2)

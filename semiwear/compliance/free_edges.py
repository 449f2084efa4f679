"""Free edges: compliance beyond that of a half-space where a flank ends.

Near a free face (the end of a tooth, or its tip) a body is more compliant than a half-space. The difference is close
to that of image loads, mirrored at the face: image of a slice j at the distance

    r^2 = s^2 + 4 e_i e_j      s: between the slices, e: their distances from the edge

A mirror image alone keeps the face plane and free of shear. The condition of zero normal stress (Hetenyi) enlarges
the image by the factor

    g = g_0 + 0.36 tau,   g_0 = 1 + nu (0.62 + 1.57 nu)/(1 - nu),   tau = 4 e_i e_j/(e_i + e_j)^2

fitted to finite elements of a quarter-space for 0 <= nu <= 0.45 (tests/reference/test_free_edges.py). It holds to 3 %
along a line normal to the edge and, up to twice the distance from the edge, along a line parallel to it; farther
along the latter the true factor continues to rise, to about 2.2 for nu = 0.3. Where the faces do not meet under a
right angle the image changes fast, see `wedge_factor`.

Tooth compliance includes the edges (prisms mirror their ends and have the true outline of the tip), so only the
*local* part has an image: the half-space displacement of the surface less that of the mid-surface at depth d,

    (1 - nu^2)/(pi E) 1/sqrt(r^2 + b^2/4)  -  (1 + nu)/(2 pi E) [d^2/r_d^3 + 2(1 - nu)/r_d],   r_d^2 = r^2 + d^2

The first term has the far field of a stripe of half-width b up to its first correction. Each body contributes
with its own edges. Valid where the pressure ends a half-width or more from the edge; a nearer slice
is placed half a half-width from it, and cells of pressure cut by an edge are outside this theory.

Sources: M. Hetenyi, J. Appl. Mech. 37 (1970) 70-76; L. M. Keer, J. C. Lee, T. Mura, Int. J. Solids Struct. 19 (1983)
497-508; R. Guilbault, J. Tribol. 133 (2011) 031402 (factor on image loads).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from math import log, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.elastic_teeth import Elastic
from semiwear.kernel_cache import inner_njit, njit
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_pair import DRIVEN, DRIVING, Borders

_NEAREST = 0.5  # half-widths: least distance of a slice from an edge
_LEAST_DEPTH = 1.5  # half-widths, as for the half-space itself
_SHARPEST = 100.0 / 90.0  # of a right angle: the limit of the fitted range
_ALIKE = 1e-12  # of a distance along an image: smaller differences count as equal
_REACH = 8.0  # depths from an edge, beyond which the image of the local part is negligible


def image_factor(poissons_ratio: float) -> tuple[float, float]:
    """Factor on the image loads of a quarter-space: for very different distances, and its increase for equal ones.

    Valid for Poisson's ratios from 0 to 0.4.
    """
    nu = poissons_ratio
    return 1.0 + nu * (0.62 + 1.57 * nu) / (1.0 - nu), 0.36


def wedge_factor(turn: ArrayLike) -> FloatArray:
    """Strength of the image where the outline turns by `turn` [rad] at the edge, relative to a right angle.

    (turn/90 degrees)^5: fitted to finite elements of wedges at nu = 0.2 and 0.3, which give 0.09, 0.20, 0.40, 0.74,
    1.35 and 1.81 where the outline turns by 55, 65, 75, 85, 95 and 100 degrees; held beyond 100.
    """
    return np.clip(np.asarray(turn, float) / (0.5 * pi), 0.0, _SHARPEST) ** 5


@dataclass(frozen=True)
class EdgeDistance:
    """Distance of an edge from the slices: (roll, face) arrays.

    Attributes
    ----------
    distance : array [mm]
        Along the flank, normal to the edge; negative beyond it.
    slope : array
        Its derivative along the contact line.
    factor : array
        On the image, see `wedge_factor`.
    """

    distance: FloatArray
    slope: FloatArray
    factor: FloatArray

    @classmethod
    def of(cls, distance: FloatArray, arc: FloatArray, turn: ArrayLike = 0.5 * pi) -> EdgeDistance:
        """An edge at distances from slices at positions `arc` along their lines [mm]; `turn` as in `wedge_factor`."""
        slope = np.zeros_like(distance)
        if arc.shape[1] > 1:
            slope = np.gradient(distance, axis=1) / np.gradient(arc, axis=1)
        return cls(distance, np.clip(slope, -1.0, 1.0), np.broadcast_to(wedge_factor(turn), distance.shape))


@dataclass(frozen=True)
class FreeBody:
    """One body with its edges.

    Attributes
    ----------
    youngs_modulus [MPa], poissons_ratio [1] : float
    depth : (roll, face) array [mm] or None
        Depth of the mid-surface; None for rigid teeth, for which nothing is subtracted.
    ends, tips : tuples of EdgeDistance
        End faces of the tooth, and tip edges.
    """

    youngs_modulus: float
    poissons_ratio: float
    depth: FloatArray | None
    ends: tuple[EdgeDistance, ...]
    tips: tuple[EdgeDistance, ...] = ()


class _Image(NamedTuple):
    """Slices of one line that have an image of a body's local compliance in edges.

    Attributes
    ----------
    arc, length : (n,) arrays [mm]
    depth : (n,) array [mm]
        Of the mid-surface; 0 where nothing is subtracted.
    distance : (edges, n) array [mm]
    slope, strong : (edges, n) arrays
        As in `EdgeDistance`, with the root of the factor.
    """

    arc: FloatArray
    length: FloatArray
    depth: FloatArray
    distance: FloatArray
    slope: FloatArray
    strong: FloatArray


class _Row(NamedTuple):
    """Mutual images of a slice and of every slice before it: (n,) arrays, of which the first entries are in use.

    Attributes
    ----------
    here, there : arrays [mm]
        Coordinate along the image from its middle, in the image of the other slice and in that of this one.
    square : array [mm^2]
        Of the distance to the image.
    factor, length : arrays [1], [mm]
        On the image, and the mean of both slices.
    quotient, ends : arrays
        Exponential of the logarithms along the image, and the other terms.
    total : array [mm]
        Displacement along the image, times 2 pi E/(1 + nu).
    """

    here: FloatArray
    there: FloatArray
    square: FloatArray
    factor: FloatArray
    length: FloatArray
    quotient: FloatArray
    ends: FloatArray
    total: FloatArray


# in loops over arrays, which compilers vectorise
@inner_njit(cache=True, error_model="numpy")
def _mirrored(image, i, single, equal, row):  # type: ignore[no-untyped-def]
    """Positions of the images of a slice and of those before it; returns whether all are the same from both sides."""
    # along the image of slice j, x from its middle: r^2 = (s + x)^2 + 4 e_i (e_j + slope x), a square and a rest
    for j in range(i + 1):
        row.here[j] = image.arc[j] - image.arc[i]
        row.there[j], row.square[j], row.factor[j] = -row.here[j], row.here[j] * row.here[j], 1.0
        row.length[j] = sqrt(image.length[i] * image.length[j])
    for edge in range(image.distance.shape[0]):
        own, turn, strong = image.distance[edge, i], image.slope[edge, i], image.strong[edge, i]
        for j in range(i + 1):
            other = image.distance[edge, j]
            both = 4.0 * own * other
            row.here[j] += 2.0 * own * image.slope[edge, j]
            row.there[j] += 2.0 * other * turn
            row.square[j] += both
            row.factor[j] *= strong * image.strong[edge, j] * (single + equal * both / (own + other) ** 2)
    alike = True
    for j in range(i + 1):
        alike &= abs(abs(row.there[j]) - abs(row.here[j])) <= _ALIKE * abs(row.here[j])
    return alike


@inner_njit(cache=True, error_model="numpy")
def _sum_with_root(x, root, square):  # type: ignore[no-untyped-def]
    """Sum of a length and the root of its square plus another square, without cancellation."""
    return x + root if x >= 0.0 else square / (root - x)


@inner_njit(cache=True, error_model="numpy")
def _between_ends(middle, length, square):  # type: ignore[no-untyped-def]
    """Exponential of the integral of 1/r along an image, r^2 = x^2 + square, and the change of x/r."""
    lower, upper = middle - 0.5 * length, middle + 0.5 * length
    first, second = sqrt(lower * lower + square), sqrt(upper * upper + square)
    quotient = _sum_with_root(upper, second, square) / _sum_with_root(lower, first, square)
    return quotient, upper / second - lower / first


@inner_njit(cache=True, error_model="numpy")
def _add_along(middle, image, i, half_surface, nu, row):  # type: ignore[no-untyped-def]
    """Add the local displacement along images, at distances `middle` from their middles, to `total`."""
    for j in range(i + 1):
        near = max(row.square[j] - middle[j] * middle[j], 0.0) + half_surface * half_surface
        row.quotient[j], _ = _between_ends(middle[j], row.length[j], near)
        row.ends[j] = 0.0
    if image.depth[i] > 0.0:
        for j in range(i + 1):
            squared = image.depth[i] * image.depth[j]
            deep = max(row.square[j] - middle[j] * middle[j], 0.0) + squared
            quotient, ends = _between_ends(middle[j], row.length[j], deep)
            row.quotient[j] /= quotient
            row.ends[j] = ends * squared / deep
    for j in range(i + 1):
        row.total[j] += 2.0 * (1.0 - nu) * log(row.quotient[j]) - row.ends[j]


@njit(cache=True, error_model="numpy", nogil=True)
def _add_rows(block, points, image, half_surface, shear, nu, single, equal):  # type: ignore[no-untyped-def]
    """Add an image of some slices, (n,), to the compliance between all slices of a line, (m, m)."""
    n = points.shape[0]
    row = _Row(
        np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    )  # fmt: skip
    for i in range(n):
        alike = _mirrored(image, i, single, equal, row)
        for j in range(i + 1):
            row.total[j] = 0.0
        _add_along(row.here, image, i, half_surface, nu, row)
        share = shear
        if not alike:  # they are for a straight line at a straight edge
            _add_along(row.there, image, i, half_surface, nu, row)
            share = 0.5 * shear
        for j in range(i + 1):
            mean = share * row.total[j] * row.factor[j] / row.length[j]
            block[points[i], points[j]] += mean
            if j < i:
                block[points[j], points[i]] += mean


class FreeEdges:
    """Images of the local compliance between slices of one line (a `SliceCompliance`).

    Parameters
    ----------
    arc, length : (roll, face) arrays [mm]
        Position along the line, and length, of each slice.
    bodies : tuple of FreeBody
    half_width : float [mm]
        Half-width of a usual load.
    strength : float
        Factor on the correction: 0 none, 1 a free edge.
    """

    def __init__(
        self,
        arc: FloatArray,
        length: FloatArray,
        bodies: tuple[FreeBody, ...],
        half_width: float,
        strength: float = 1.0,
    ) -> None:
        if not 0.0 <= strength <= 1.0:
            raise ValueError(f"strength: from 0 to 1, not {strength!r}")
        self.arc, self.length, self.bodies = arc, length, bodies
        self.half_width, self.strength = half_width, strength

    @classmethod
    def of(
        cls,
        lines: ContactLines,
        borders: Borders,
        materials: tuple[Elastic, Elastic],
        depths: tuple[FloatArray, FloatArray] | None,
        half_width: float,
        *,
        tip_turns: tuple[ArrayLike, ArrayLike],
        strength: float = 1.0,
    ) -> FreeEdges:
        """Free edges of a pair of flanks: both end faces and the tip of each body.

        Parameters
        ----------
        lines : ContactLines
        borders : Borders
            Nominal edges at the face stations of the lines (`sharp=True`).
        materials : (Elastic, Elastic)
            Driving and driven body.
        depths : pair of (roll, face) arrays [mm], or None
            Depth of the mid-surface of the driving and the driven body; None for rigid teeth.
        half_width : float [mm]
            Half-width of a usual load.
        tip_turns : pair of floats or (face,) arrays [rad]
            Angle by which the outline of the driving and the driven body turns at the tip edge: 90 degrees less the
            pressure angle there, or the flank's inclination.
        strength : float
            From 0 to 1.
        """
        shape = lines.profile.shape
        face = np.broadcast_to(lines.face, shape)
        places = {DRIVING: (lines.driving_face, borders.driving_face), DRIVEN: (face, borders.face)}
        to_tip = {
            DRIVING: borders.driving_tip - lines.driving_profile,
            DRIVEN: (borders.tip - lines.profile) * lines.spacing,
        }
        bodies = []
        for body in (DRIVING, DRIVEN):
            at, (lower, upper) = places[body]
            bodies.append(
                FreeBody(
                    materials[body].youngs_modulus,
                    materials[body].poissons_ratio,
                    None if depths is None else depths[body],
                    (EdgeDistance.of(at - lower, lines.arc), EdgeDistance.of(upper - at, lines.arc)),
                    (EdgeDistance.of(to_tip[body], lines.arc, tip_turns[body]),),
                )
            )
        return cls(lines.arc, lines.length, tuple(bodies), half_width, strength)

    def matrix(self, at: tuple[IntArray, IntArray], starts: IntArray) -> FloatArray:
        """Additional compliance between slices due to free edges, see `SliceCompliance` [mm/N]."""
        total = np.zeros((at[0].size, at[0].size))
        for first, last in pairwise(starts):
            line = at[0][first:last], at[1][first:last]
            for body in self.bodies:
                # images in an end, in a tip, and in their corner
                for chosen in product((None, *body.ends), (None, *body.tips)):
                    edges = tuple(edge for edge in chosen if edge is not None)
                    if edges and last > first:
                        self._add_image(total[first:last, first:last], line, body, edges)
        return self.strength * total

    def _add_image(
        self, block: FloatArray, line: tuple[IntArray, IntArray], body: FreeBody, edges: tuple[EdgeDistance, ...]
    ) -> None:
        """Add the image of a body's local compliance in edges to the block of one line."""
        rolls, faces = line
        near = np.ones(rolls.size, dtype=bool)
        if body.depth is not None:
            reach = _REACH * float(body.depth[line].max())
            for edge in edges:
                near &= edge.distance[line] < reach
        rolls, faces = rolls[near], faces[near]
        if rolls.size == 0:
            return
        nu, nearest = body.poissons_ratio, _NEAREST * self.half_width
        depth = np.zeros(rolls.size)
        if body.depth is not None:
            depth = np.maximum(body.depth[rolls, faces], _LEAST_DEPTH * self.half_width)
        image = _Image(
            self.arc[rolls, faces], self.length[rolls, faces], depth,
            np.array([np.maximum(edge.distance[rolls, faces], nearest) for edge in edges]),
            np.array([edge.slope[rolls, faces] for edge in edges]),
            np.array([np.sqrt(edge.factor[rolls, faces]) for edge in edges]),
        )  # fmt: skip
        shear = (1.0 + nu) / (2.0 * pi * body.youngs_modulus)
        _add_rows(block, np.flatnonzero(near), image, 0.5 * self.half_width, shear, nu, *image_factor(nu))

"""The oblique ends of an inclined tooth.

An inclined tooth ends in planes across the axis, its prism in planes across itself. Where the loaded flank reaches
farther than the other, the corner is acute and yields half as much again; at the other end the tooth backs it up.
A stretch of one tooth with some ground below is computed twice in three dimensions, with its own ends and with square
ones; the difference is what the prism lacks. In the coordinates of the section (x, y) and z along the axis,

    d/dx -> d/dx + sin(beta) d/dz,    d/ds -> cos(beta) d/dz        (s along the tooth)

so that the elements are those of the section times quadratic ones along z, and with strains B0 q + B1 dq/dz

    K = K00 (x) M + K01 (x) G + K01' (x) G' + K11 (x) S,     M, G, S: integrals of the shape functions along z.

The section is coarse: only the difference counts, and that is far less than the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from semiwear.compliance.prism import fillet_edges, fillet_shares, mid_surface, section_integrals
from semiwear.compliance.quadratic import quadratic_slopes, quadratic_values, quadratic_weights
from semiwear.compliance.section_mesh import SectionMesh, section_mesh
from semiwear.geometry.section import RingRim, ToothSection

__all__ = ["HEIGHTS", "EndEffect", "end_effect"]

FloatArray = NDArray[np.float64]

HEIGHTS = 5
"""Load heights of the stretch."""

_GROUND = 1.5  # depth of the ground below the root, in modules
_FIRST = 0.375  # length of the element at an end, in modules
_ELEMENTS = 12  # along the tooth
_SECTION = {"heights": HEIGHTS, "fillet_elements": 2, "elements_across": 1, "elements_below": 2}


@dataclass(frozen=True)
class EndEffect:
    """What oblique ends add on the loaded tooth.

    Attributes
    ----------
    stations : (S,) array [mm]
        Along the axis, from the middle of the width.
    deflection : (S H, S H) array [mm/N]
        Of the mid-surface, by loads normal to the flank at stations and load heights; symmetric. A load between
        stations is shared by both.
    stress : (S, F, S H) array [MPa/N]
        Tangential stress of the fillet on the loaded side, by the same loads.
    fillet_share : (F,) array
        Where, as a share of the fillet's length from the end of the flank.
    """

    stations: FloatArray
    deflection: FloatArray
    stress: FloatArray
    fillet_share: FloatArray


def end_effect(
    section: ToothSection,
    *,
    width: float,
    slant: float,
    module: float,
    youngs_modulus: float,
    poissons_ratio: float,
    name: str = "tooth section",
) -> EndEffect:
    """What the oblique ends of a tooth add to its prism.

    Parameters
    ----------
    section : ToothSection
        Normal to the tooth [mm].
    width : float [mm]
        Between the ends, along the axis.
    slant : float [rad]
        Helix angle, positive when the tooth goes with z towards where the load pushes it.
    module : float [mm]
        Normal module, by which the ground below the tooth and the elements are measured.
    youngs_modulus : float [MPa]
    poissons_ratio : float
    name : str
        What error messages call the section.
    """
    mesh = section_mesh(_on_shallow_ground(section, _GROUND * module), name=name, **_SECTION)
    stations = _stations(width, _FIRST * module)
    solid = _Stretch(mesh, stations, youngs_modulus, poissons_ratio)
    true, square = (solid.influence(cos(slant), lean) for lean in (sin(slant), 0.0))
    difference = true.deflection - square.deflection
    return EndEffect(
        stations=stations,
        deflection=0.5 * (difference + difference.T),
        stress=true.stress - square.stress,
        fillet_share=fillet_shares(mesh),
    )


def _on_shallow_ground(section: ToothSection, depth: float) -> ToothSection:
    """The section held at a depth below its root, or where it is held if that is nearer."""
    rim, root = section.rim, section.fillet[-1]
    if isinstance(rim, RingRim):
        bore = max(rim.bore_radius, float(np.hypot(*root)) - depth)
        return replace(section, rim=replace(rim, bore_radius=bore))
    return replace(section, rim=replace(rim, back_height=max(rim.back_height, float(root[1]) - depth)))


def _stations(width: float, first: float) -> FloatArray:
    """Corners and middles of elements that grow from a first length at either end towards the middle."""
    half, count = 0.5 * width, _ELEMENTS // 2
    growth = max(1.0, np.log(min(first / half, 0.5)) / np.log(1.0 / count))
    inner = half * (np.arange(count + 1) / count) ** growth - half
    corners = np.concatenate([inner, -inner[-2::-1]])
    return np.sort(np.concatenate([corners, 0.5 * (corners[1:] + corners[:-1])]))


class _Influence(NamedTuple):
    deflection: FloatArray  # (S H, S H)
    stress: FloatArray  # (S, F, S H)


@dataclass(frozen=True)
class _Stretch:
    """A stretch of tooth: quadratic elements in the section and along the axis, its ends free, its ground held."""

    mesh: SectionMesh
    stations: FloatArray
    youngs_modulus: float
    poissons_ratio: float

    def influence(self, along: float, lean: float) -> _Influence:
        """Influence of loads on the flank, where d/ds = along d/dz and d/dx takes in lean d/dz."""
        mesh, z = self.mesh, self.stations
        free = np.setdiff1d(np.arange(len(mesh.nodes)), mesh.held)
        unknowns = (3 * free[:, None] + np.arange(3)).ravel()
        integrals = section_integrals(mesh, self.youngs_modulus, self.poissons_ratio, along, lean)
        parts = tuple(k[unknowns][:, unknowns].toarray() / along for k in integrals)

        places, hats = _hats(z)
        rows = np.zeros((len(mesh.nodes), 3, HEIGHTS))
        rows[mesh.flank, :2, np.arange(HEIGHTS)] = mesh.flank_normal
        loads = np.einsum("nh,st->tnsh", rows.reshape(-1, HEIGHTS)[unknowns], hats @ quadratic_weights(z, places))
        moved = _solved(parts, z, loads.reshape(z.size, unknowns.size, -1))

        everywhere = np.zeros((z.size, 3 * len(mesh.nodes), moved.shape[2]))
        everywhere[:, unknowns] = moved
        whole: FloatArray = everywhere.reshape(z.size, len(mesh.nodes), 3, -1)
        return _Influence(self._deflection(whole, places, hats, lean), self._stress(whole, along, lean))

    def _deflection(self, moved: FloatArray, places: FloatArray, hats: FloatArray, lean: float) -> FloatArray:
        """Of the mid-surface behind each flank place, in the section normal to the tooth, where there is one."""
        mesh, z = self.mesh, self.stations
        nodes, weights, middle = mid_surface(mesh)
        seen = np.empty((z.size, HEIGHTS, moved.shape[3]))
        for height in range(HEIGHTS):
            there = np.einsum("k,skil,i->sl", weights[height], moved[:, nodes[height], :2], mesh.flank_normal[height])
            behind = places + lean * (middle[height, 0] - mesh.nodes[mesh.flank[height], 0])
            seen[:, height] = hats @ quadratic_weights(z, np.clip(behind, z[0], z[-1])) @ there
        return seen.reshape(-1, moved.shape[3])

    def _stress(self, moved: FloatArray, along: float, lean: float) -> FloatArray:
        nodes, slopes, values, tangent, _ = fillet_edges(self.mesh)
        steady = np.einsum("fa,fi,sfail->sfl", slopes, tangent, moved[:, nodes, :2], optimize=True)
        tangential = np.einsum("fa,fi,sfail->sfl", values, tangent, moved[:, nodes, :2], optimize=True)
        axial = np.einsum("fa,sfal->sfl", values, moved[:, nodes, 2], optimize=True)
        by_z = lean * tangent[None, :, :1] * tangential + self.poissons_ratio * along * axial
        strain = steady + np.tensordot(_slopes(self.stations), by_z, axes=1)
        return self.youngs_modulus / (1.0 - self.poissons_ratio**2) * strain


def _solved(parts: tuple[FloatArray, ...], z: FloatArray, loads: FloatArray) -> FloatArray:
    """Displacement of every plane under loads on the planes, both (S, n, loads): elimination from end to end."""
    n = loads.shape[1]
    elements = [_element(parts, z[2 * e + 2] - z[2 * e]) for e in range(z.size // 2)]
    stiffness, load = elements[0][:n, :n], loads[0]
    passed = []
    for e, element in enumerate(elements):
        factor = cho_factor(stiffness, lower=True, check_finite=False)
        coupling = np.zeros((len(stiffness), 2 * n))
        coupling[-n:] = element[:n, n:]
        carried = cho_solve(factor, coupling, check_finite=False)
        passed.append((factor, carried, load))
        stiffness = element[n:, n:] - coupling[-n:].T @ carried[-n:]
        if e + 1 < len(elements):
            stiffness[n:, n:] += elements[e + 1][:n, :n]
        load = np.concatenate([loads[2 * e + 1], loads[2 * e + 2]]) - carried.T @ load
    moved = [cho_solve(cho_factor(stiffness, lower=True, check_finite=False), load, check_finite=False)]
    for factor, carried, load in reversed(passed):
        moved.append(cho_solve(factor, load, check_finite=False) - carried @ moved[-1])
    return np.concatenate(moved[::-1]).reshape(loads.shape)


def _element(parts: tuple[FloatArray, ...], length: float) -> FloatArray:
    """Stiffness (3 n, 3 n) of the three planes of a quadratic element along z."""
    at, weight = np.polynomial.legendre.leggauss(3)
    value, slope = quadratic_values(at), quadratic_slopes(at)
    mass = (value * weight) @ value.T * (length / 2.0)
    mixed = (value * weight) @ slope.T
    stiff = (slope * weight) @ slope.T * (2.0 / length)
    k00, k01, k11 = parts
    return np.kron(mass, k00) + np.kron(mixed, k01) + np.kron(mixed.T, k01.T) + np.kron(stiff, k11)


def _hats(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places along z, and weights (S, places) of each station's hat function there, summing to one."""
    at, weight = np.polynomial.legendre.leggauss(4)
    middle, half = 0.5 * (z[1:] + z[:-1])[:, None], 0.5 * np.diff(z)[:, None]
    places = (middle + half * at).ravel()
    hats = np.stack([np.interp(places, z, unit) for unit in np.eye(z.size)]) * (half * weight).ravel()
    return places, hats / hats.sum(axis=1, keepdims=True)


def _slopes(z: FloatArray) -> FloatArray:
    """Derivative by z at the planes, the mean of both elements where they meet: (S, S) array."""
    slopes, shared = np.zeros((z.size, z.size)), np.zeros((z.size, 1))
    for first in range(0, z.size - 1, 2):
        length = z[first + 2] - z[first]
        slopes[first : first + 3, first : first + 3] += quadratic_slopes(np.array([-1.0, 0.0, 1.0])).T * 2.0 / length
        shared[first : first + 3] += 1.0
    return slopes / shared

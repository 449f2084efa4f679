"""One pitch of a toothed body, condensed onto its sides at wave numbers along its width.

A pitch is symmetric about its centre line: fields are even (u odd in x, v and w even) or odd, and each kind is found
on the loaded half. Its unknowns are eliminated level by level, from the tip to the side in the middle of the tooth
space: a level is coupled only to the next, through the edges between their elements (`condensation`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_matrix, eye_array

from semiwear.arrays import FloatArray
from semiwear.compliance.condensation import factors_of, halves, levels_towards
from semiwear.compliance.section_elements import HarmonicMatrices, unknowns_of
from semiwear.compliance.section_mesh import SectionMesh
from semiwear.geometry.section import RingRim, ToothSection

_MIRROR = np.array([-1.0, 1.0, 1.0])  # of (u, v, w)


@dataclass(frozen=True)
class Condensed:
    """One pitch at n wave numbers, in terms of its sides (left, then right; s unknowns each) and its own loads.

    Attributes
    ----------
    stiffness : (n, 2 s, 2 s) array
        Stiffness of the sides.
    side_load : (n, 2 s, H) array
        Loads on the sides by unit loads on the flank.
    deflection : (n, H, 2 s) array
        Observed deflection for unit displacements of the sides.
    deflection_load : (n, H, H) array
        Observed deflection for unit loads on the pitch's own flank with its sides held.
    stress : (n, F, 2 s) array
        Observed stress for unit displacements of the sides.
    stress_load : (n, F, H) array
        Observed stress for unit loads on the pitch's own flank with its sides held.
    """

    stiffness: FloatArray
    side_load: FloatArray
    deflection: FloatArray
    deflection_load: FloatArray
    stress: FloatArray
    stress_load: FloatArray


@dataclass(frozen=True)
class PitchRows:
    """Loads and readings of one pitch: rows on the unknowns of its mesh, ``fixed + k * along`` at wave number k.

    Attributes
    ----------
    fixed, along : (R, 3 N) sparse matrices
        Of nodes of the loaded half.
    load, deflection, stress : slices
        Rows of unit loads (H of them), readings of deflection and readings of stress (F). A row may be both
        load and reading.
    """

    fixed: csr_matrix
    along: csr_matrix
    load: slice
    deflection: slice
    stress: slice


class _Level(NamedTuple):
    """The u unknowns of a level in fields of one symmetry, as polynomials of the wave number.

    Attributes
    ----------
    own : (3, u, u) array
        Stiffness: coefficients of 1, k and k^2.
    coupling : (3, u, v) array
        To the last v unknowns of the next level, likewise; to no others.
    rows : (2, R, u) array
        Loads and readings: coefficients of 1 and k.
    """

    own: FloatArray
    coupling: FloatArray
    rows: FloatArray


@dataclass(frozen=True)
class Pitch:
    """Stiffness of one pitch whose sides are free, with its loads and readings; held unknowns are left out.

    Attributes
    ----------
    even, odd : lists of _Level
        From the tip to the side, whose unknowns are in axes of its own.
    load, deflection, stress : slices
        See `PitchRows`.
    """

    even: list[_Level]
    odd: list[_Level]
    load: slice
    deflection: slice
    stress: slice

    @classmethod
    def of(cls, mesh: SectionMesh, section: ToothSection, half: HarmonicMatrices, rows: PitchRows) -> Pitch:
        """Order the matrices of one pitch.

        Parameters
        ----------
        mesh : SectionMesh
            The loaded half of one pitch of the section.
        section : ToothSection
            Its rim defines the angle between the sides.
        half : HarmonicMatrices
            K0, K1 and K2 of its stiffness K0 + k K1 + k^2 K2, (3 N, 3 N) each.
        rows : PitchRows
        """
        kept = np.zeros(len(mesh.nodes), dtype=bool)
        kept[mesh.elements], kept[mesh.held] = True, False
        levels = levels_towards(mesh.right[kept[mesh.right]], mesh.elements, kept)
        nodes = np.concatenate([level for level, _ in levels])
        side = levels[-1][0].size
        turns = [eye_array(3 * (nodes.size - side)), *side * [_turn(_side_angle(section))]]
        turned = eye_array(3 * len(mesh.nodes), format="csc")[:, unknowns_of(nodes)] @ block_diag(turns, format="csc")
        stiffness = [turned.T @ (matrix @ turned) for matrix in half]
        observed = np.stack([(matrix @ turned).toarray() for matrix in (rows.fixed, rows.along)])
        beside, sideways = ~np.isin(nodes, mesh.centre_line)[:, None], np.array([True, False, False])
        even, odd = ((beside | free).ravel() for free in (~sideways, sideways))
        fields: tuple[list[_Level], list[_Level]] = [], []
        ends = [0, *3 * np.cumsum([level.size for level, _ in levels]), 3 * nodes.size]
        met = [3 * count for _, count in levels[1:]] + [0]
        for begin, end, after, coupled in zip(ends, ends[1:], ends[2:], met, strict=False):
            block = np.stack([matrix[begin:end, begin:after].toarray() for matrix in stiffness])
            first = after - coupled
            for of_symmetry, free in zip(fields, (even, odd), strict=True):
                own, following = np.flatnonzero(free[begin:end]), np.flatnonzero(free[first:after]) + first - begin
                parts = block[:, own[:, None], own], block[:, own[:, None], following], observed[..., begin + own]
                of_symmetry.append(_Level(*parts))
        return cls(*fields, rows.load, rows.deflection, rows.stress)

    def condense(self, wave_numbers: FloatArray) -> Condensed:
        """Eliminate the inner unknowns at wave numbers [1/mm]."""
        even, odd = (_condensed(part, wave_numbers) for part in (self.even, self.odd))
        mirror = np.tile(_MIRROR, even.stiffness.shape[1] // 3)
        # right = even + odd, and left = even - odd in the mirror: halves of the energy and of the readings add
        alike, across = 0.5 * (even.stiffness + odd.stiffness), 0.5 * (even.stiffness - odd.stiffness)
        stiffness = np.block([[mirror[:, None] * alike * mirror, mirror[:, None] * across], [across * mirror, alike]])
        seen = 0.5 * np.concatenate([(even.seen - odd.seen) * mirror, even.seen + odd.seen], axis=2)
        own = 0.5 * (even.by_loads + odd.by_loads)[:, :, self.load]
        return Condensed(
            stiffness=stiffness,
            side_load=seen[:, self.load].swapaxes(1, 2),
            deflection=seen[:, self.deflection],
            deflection_load=own[:, self.deflection],
            stress=seen[:, self.stress],
            stress_load=own[:, self.stress],
        )


class _Side(NamedTuple):
    """Fields of one symmetry at n wave numbers, in terms of the s unknowns of the side.

    Attributes
    ----------
    stiffness : (n, s, s) array
    seen : (n, R, s) array
        Readings of the side's motion.
    by_loads : (n, R, R) array
        Readings of unit loads with the side held.
    """

    stiffness: FloatArray
    seen: FloatArray
    by_loads: FloatArray


def _condensed(levels: list[_Level], wave_numbers: FloatArray) -> _Side:
    powers = wave_numbers[:, None] ** np.arange(3)
    own, rows = _at(powers, levels[0].own), _at(powers, levels[0].rows)
    by_loads = np.zeros((len(powers), rows.shape[1], rows.shape[1]))
    for level, following in pairwise(levels):
        factor = factors_of(own)
        loaded, onto = halves(factor, rows.swapaxes(1, 2)), halves(factor, _at(powers, level.coupling))
        by_loads += loaded.swapaxes(1, 2) @ loaded
        own, rows = _at(powers, following.own), _at(powers, following.rows)
        first = own.shape[1] - onto.shape[2]
        own[:, first:, first:] -= onto.swapaxes(1, 2) @ onto
        rows[:, :, first:] -= loaded.swapaxes(1, 2) @ onto
    return _Side(own, rows, by_loads)


def _at(powers: FloatArray, coefficients: FloatArray) -> FloatArray:
    return np.tensordot(powers[:, : len(coefficients)], coefficients, 1)


def _turn(angle: float) -> FloatArray:
    """Unknowns in axes turned clockwise by an angle -> unknowns (u, v, w)."""
    return np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def _side_angle(section: ToothSection) -> float:
    """Half the angle between the sides of a pitch [rad]; those of a rack are parallel."""
    return np.pi / section.rim.teeth if isinstance(section.rim, RingRim) else 0.0

"""Flank deviations from a scene's effects: material removed before any wear.

`DEVIATIONS` lists the effects that give one; each is a function of the place on the flank of one body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_modification import FlankModification, Relief
from semiwear.meshing.flank_pair import DRIVEN, DRIVING, FlankPair
from semiwear.scene import EffectTable
from semiwear.untyped import Value

_UM = 1e-3  # mm


class FlankDeviation(Protocol):
    """Material removed from a flank, along its normal."""

    @property
    def tallest(self) -> float:
        """Bound on the difference in depth between two places of the flank [mm]."""

    def depth(
        self, profile: ArrayLike, face: ArrayLike, root: ArrayLike, tip: ArrayLike, ends: tuple[float, float]
    ) -> FloatArray:
        """Material removed at flank points [mm], as `FlankModification.depth`; >= 0."""


def _modification(table: Value, name: str) -> FlankModification:
    deviations = None
    if table.file is not None:
        from semiwear.meshing.deviation_grid import read_deviation_grid  # few scenes name such a file

        deviations = read_deviation_grid(table.file, f"effects.{name}.file")
    return FlankModification(
        tip_relief=Relief(_UM * table.tip_relief_um, table.tip_relief_length_mm, table.relief_shape),
        root_relief=Relief(_UM * table.root_relief_um, table.root_relief_length_mm, table.relief_shape),
        crowning=_UM * table.crowning_um,
        lead_slope=_UM * table.lead_slope_um,
        bias=_UM * table.bias_um,
        deviations=deviations,
    )


DEVIATIONS: Mapping[str, tuple[int, Callable[[Value, str], FlankDeviation]]] = {
    "modification.pinion": (DRIVING, _modification),
    "modification.gear": (DRIVEN, _modification),
}
"""By the name of an effect: the body whose flank deviates, and the deviation from the effect's table and name."""


def deviations_of(present: Iterable[tuple[str, EffectTable]], body: int) -> tuple[FlankDeviation, ...]:
    """Deviations of the flank of a body from the scene's effects.

    Parameters
    ----------
    present : (name, table) of effects
        As `Effects.present` gives them.
    body : int
    """
    known = ((name, table, *DEVIATIONS[name]) for name, table in present if name in DEVIATIONS)
    return tuple(make(table, name) for name, table, whose, make in known if whose == body)


def tallest(present: Iterable[tuple[str, EffectTable]]) -> float:
    """Greatest difference in gap between two slices by the deviations of both flanks [mm]."""
    listed = list(present)
    return sum((part.tallest for body in (DRIVING, DRIVEN) for part in deviations_of(listed, body)), 0.0)


def depth_between(
    present: Iterable[tuple[str, EffectTable]], pair: FlankPair, lines: ContactLines, grid: FlankGrid
) -> FloatArray | None:
    """Material removed from both flanks by deviations, at the driven flank's nodes and their mating points.

    Returns
    -------
    (1 or roll, face, profile) array [mm], or None without deviations
    """
    listed = list(present)
    driven, driving = (deviations_of(listed, body) for body in (DRIVEN, DRIVING))
    depth: FloatArray | None = None
    if driven or driving:
        borders = pair.borders(grid.face)
    for deviation in driven:
        ends = (borders.root[:, None], borders.tip[:, None])
        own = deviation.depth(grid.profile, grid.face[:, None], *ends, borders.face)[None]
        depth = own if depth is None else own + depth
    if driving:
        from_line = grid.profile - lines.profile[..., None]
        profile = lines.driving_profile[..., None] + lines.driving_slope[..., None] * from_line
        face = np.broadcast_to(lines.driving_face[..., None], profile.shape)
        can_touch = (lines.separation[0] < np.inf)[..., None]
    for deviation in driving:
        met = deviation.depth(profile, face, borders.driving_root, borders.driving_tip, borders.driving_face)
        met = np.where(can_touch, met, 0.0)
        depth = met if depth is None else met + depth
    return depth

"""Surfaces as points and facets with values at the points, written for viewers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from semiwear.arrays import FloatArray, IntArray
from semiwear.errors import MissingExtraError
from semiwear.targets import replacing

_TRIANGLES = ((0, 1, 2), (0, 2, 3))  # of a facet with four corners
_SERIES = """\
<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
{}
  </Collection>
</VTKFile>
"""


@dataclass(frozen=True)
class Surface:
    """Points in a body's own frame (its axis is z), facets, and values at the points.

    Attributes
    ----------
    points : (n, 3) array [mm]
    quads : (m, 4) int array
        Points of each facet, anticlockwise as seen from outside the material.
    fields : mapping from name to (n,) array
    units : mapping from name to str
    """

    points: FloatArray
    quads: IntArray
    fields: Mapping[str, FloatArray]
    units: Mapping[str, str] = field(default_factory=dict)


def grid_of_quads(rows: int, columns: int) -> IntArray:
    """Facets of a grid of points that are numbered row by row, ((rows - 1) (columns - 1), 4)."""
    number = np.arange(rows * columns).reshape(rows, columns)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.stack([corner.ravel() for corner in corners], axis=1)


def write_surface(target: Path, surface: Surface) -> None:
    """Write a surface as .vtu (with its fields) or as .stl (facets only, in millimetres).

    Raises
    ------
    MissingExtraError
        Without meshio.
    """
    try:
        import meshio
    except ImportError as error:
        raise MissingExtraError("meshio", "view", "a file for viewers") from error
    stl = target.suffix.casefold() == ".stl"
    if stl:  # only triangles
        cells = [("triangle", np.concatenate([surface.quads[:, split] for split in _TRIANGLES]))]
        fields = {}
    else:
        cells = [("quad", surface.quads)]
        fields = {
            f"{name} [{surface.units[name]}]" if surface.units.get(name, "1") != "1" else name: values
            for name, values in surface.fields.items()
        }
    with replacing(target) as part:
        meshio.Mesh(surface.points, cells, point_data=fields).write(
            part, file_format="stl" if stl else "vtu", **({"binary": True} if stl else {})
        )


def write_series(target: Path, surfaces: Mapping[float, Surface]) -> None:
    """Write surfaces over meshes as a .pvd file, and a .vtu file of each in a folder of the same name."""
    folder = target.with_suffix("")
    folder.mkdir(exist_ok=True)
    lines = []
    for k, (meshes, surface) in enumerate(surfaces.items()):
        file = folder / f"{k:04d}.vtu"
        write_surface(file, surface)
        lines.append(f'    <DataSet timestep="{meshes!r}" file="{folder.name}/{file.name}"/>')
    with replacing(target) as part:
        part.write_text(_SERIES.format("\n".join(lines)), encoding="utf-8")

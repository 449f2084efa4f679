"""Files with profile and lead traces: tables (.csv) and the curve files of Klingelnberg machines (.mka).

CSV, separated by commas, semicolons or tabs; one line for each point, in any order; lines that begin with # are
skipped:

    kind, tooth, flank, diameter_mm, z_mm, deviation_um
    profile, 1, left, 54.2, 7.0, -1.3
    lead, 1, left, 72.0, 0.5, 0.8

`kind` is "profile" or "lead", `flank` "left" or "right"; z counts from the lower end of the face. In place of
`diameter_mm` a column `roll_length_mm` may hold the length of roll (ISO 21771), which needs `base_diameter`.

MKA: text that begins with ``HEADER KS.MK.FILE`` or holds curves under lines such as

    Profil:  Zahn-Nr.: 1 links / 480 Werte / z= 12.5
    Flankenlinie:  Zahn-Nr.: 1 rechts / 480 Werte / d= 65.1

with deviations in um, and -2147483.648 for points not measured. The header gives the ranges: da and de, the start and
end diameters of profiles, ba and be, the start and end of leads along the axis; the first number is for the left
flank, the second for the right flank. A lead with ``x=`` is given by its length of roll. Points are assumed to be
equidistant in the length of roll of a profile, and along the axis for a lead.

There is no public definition of the MKA format; the layout is that of files of the software STI (versions 3 to 5), in
German. GDE files (VDI/VDE 2610), whose element names are not public either, are not read: export curves as CSV.
"""

from __future__ import annotations

import os
import re
from collections import defaultdict
from pathlib import Path

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.measured.traces import FLANKS, KINDS, Trace
from semiwear.plain_text import one_of, rows_of

_ALLOWED = "a .csv or .mka file with profile and lead traces"
_SIDES = {"links": "left", "rechts": "right"}
_UNDEFINED = -2147483.0  # at or below: a point that was not measured
_HEAD = re.compile(
    r"Zahn-Nr\.:\s*(?P<tooth>\d+)\s*[a-z]?\s*(?:/\s*\w+:\s*\d+)?\s*(?P<side>links|rechts)\s*/\s*(?P<count>\d+)\s*Werte"
    r"\s*/?\s*(?P<axis>[xzd])\s*=\s*(?P<place>[-+]?[\d.]+)"
)
_RANGE = re.compile(r"\b(?P<name>da|de|ba|be)\s*\[mm\][.\s]*:\s*(?P<values>[-+\d.\s]+)$")
_PREAMBLE = re.compile(r"^(?P<key>PROFILE|UNITS)\s*:?\s+(?P<value>\w+)")
_EXPECTED = {"PROFILE": ("diam", "durch"), "UNITS": ("mm", "metri")}
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_COLUMNS = ("kind", "tooth", "flank", "z_mm", "deviation_um")


def read_traces(path: str | os.PathLike[str], *, base_diameter: float | None = None) -> tuple[Trace, ...]:
    """Profile and lead traces from a file, for `flank_from_traces`.

    Parameters
    ----------
    path : path
        A .csv or .mka file, see the module's description of both formats.
    base_diameter : float, optional
        Of the body [mm], to convert lengths of roll to diameters; needed for .mka files, and for .csv files with
        lengths of roll.

    Raises
    ------
    SceneError
        With the file, its defect, and its position.
    """
    file = Path(path)
    if not file.is_file():
        raise SceneError.of("path", str(file), _ALLOWED, "no such file")
    if base_diameter is not None and not base_diameter > 0.0:
        raise SceneError.of("base_diameter", base_diameter, "> 0 mm", "give the diameter of the base circle")
    data = file.read_bytes()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # written by many measuring machines
    if file.suffix.casefold() == ".csv":
        return _from_csv(text, file, base_diameter)
    if file.suffix.casefold() == ".mka":
        return _from_mka(text, file, base_diameter)
    raise SceneError.of("path", str(file), _ALLOWED, "name it .csv or .mka, whichever it is")


def _refused(file: Path, found: str, allowed: str, fix: str = "export it again") -> SceneError:
    return SceneError.of("traces", f"{file}: {found}", allowed, fix)


def _rolled(length: FloatArray, base_diameter: float | None, file: Path) -> FloatArray:
    """Diameters at lengths of roll [mm]."""
    if base_diameter is None:
        fix = "base_diameter = m_t z cos(alpha_t)"
        raise SceneError.of("base_diameter", None, f"the base diameter, for the lengths of roll in {file}", fix)
    return np.asarray(2.0 * np.hypot(length, 0.5 * base_diameter))


# ---- CSV


def _from_csv(text: str, file: Path, base_diameter: float | None) -> tuple[Trace, ...]:
    try:
        rows = rows_of(text)
    except ValueError as error:
        raise _refused(file, f"no table ({error})", "one point a line") from None
    head = rows[0] if rows else []
    across = next((name for name in ("diameter_mm", "roll_length_mm") if name in head), "diameter_mm")
    missing = [name for name in (*_COLUMNS, across) if name not in head]
    if missing:
        allowed = f"columns {', '.join(_COLUMNS)} and diameter_mm or roll_length_mm"
        raise _refused(file, f"no column {missing[0]}", allowed, "name the columns so")
    column = {name: k for k, name in enumerate(head)}
    points: dict[tuple[str, str, int, float], list[tuple[float, float, float]]] = defaultdict(list)
    for number, row in enumerate(rows[1:], start=2):
        where = f"line {number}"
        if len(row) != len(head):
            raise _refused(file, f"{where} has {len(row)} cells, the first {len(head)}", "one point a line")
        kind, flank = row[column["kind"]], row[column["flank"]]
        if kind not in KINDS or flank not in FLANKS:
            allowed = f"kind {one_of(KINDS)}, flank {one_of(FLANKS)}"
            raise _refused(file, f"{where}: kind {kind!r}, flank {flank!r}", allowed)
        try:
            tooth = int(row[column["tooth"]])
            place, z, deviation = (float(row[column[name]]) for name in (across, "z_mm", "deviation_um"))
        except ValueError as error:
            raise _refused(file, f"{where}: {error}", "numbers with a decimal point", "correct the cell") from None
        points[kind, flank, tooth, z if kind == "profile" else place].append((place, z, deviation))
    traces = []
    for (kind, flank, tooth, _), entries in points.items():
        place, z, deviation = np.array(entries).T
        diameter = place if across == "diameter_mm" else _rolled(place, base_diameter, file)
        traces.append(Trace(kind, flank, tooth, diameter, z, deviation))
    if not traces:
        raise _refused(file, "no points", "one trace or more")
    return tuple(traces)


# ---- MKA


def _from_mka(text: str, file: Path, base_diameter: float | None) -> tuple[Trace, ...]:
    lines = text.splitlines()
    ranges: dict[str, FloatArray] = {}
    for line in lines:
        setting = _PREAMBLE.match(line)
        if setting is not None and not setting["value"].casefold().startswith(_EXPECTED[setting["key"]]):
            allowed = "ranges as diameters, in millimetres"
            raise _refused(file, f"{setting['key']} {setting['value']}", allowed, "export it with these, or as CSV")
        limits = _RANGE.search(line.strip())
        if limits is not None:
            ranges[limits["name"]] = np.array([float(value) for value in _NUMBER.findall(limits["values"])])
    heads = [(k, found) for k, line in enumerate(lines) if (found := _HEAD.search(line)) is not None]
    if not heads:
        raise _refused(file, "no curves", "lines such as: Profil: Zahn-Nr.: 1 links / 480 Werte / z= 12.5")
    missing = [name for name in ("da", "de", "ba", "be") if ranges.get(name, np.zeros(0)).size == 0]
    if missing:
        raise _refused(file, f"no range {missing[0]} [mm] in its header", "da, de, ba and be in millimetres")
    return tuple(_curve(lines, k, found, ranges, file, base_diameter) for k, found in heads)


def _curve(
    lines: list[str], at: int, head: re.Match[str], ranges: dict[str, FloatArray], file: Path,
    base_diameter: float | None,
) -> Trace:  # fmt: skip
    count, place, flank = int(head["count"]), float(head["place"]), _SIDES[head["side"]]
    values: list[float] = []
    for line in lines[at + 1 :]:
        words = line.split()
        if len(values) >= count or (words and not all(_NUMBER.fullmatch(word) for word in words)):
            break
        values += [float(word) for word in words]
    if len(values) != count or count < 2:
        found = f"tooth {head['tooth']} {head['side']}: {len(values)} values, {count} in its heading"
        raise _refused(file, found, "as many as in its heading", "it is cut off or damaged: export it again")
    side = FLANKS.index(flank)
    share, deviation = np.linspace(0.0, 1.0, count), np.array(values)
    if head["axis"] == "z":
        kind = "profile"
        start, end = (_of_side(ranges[name], side) for name in ("da", "de"))
        if base_diameter is None:
            raise SceneError.of("base_diameter", None, f"the base diameter of the body measured in {file}",
                                "base_diameter = m_t z cos(alpha_t)")  # fmt: skip
        rolls = [np.sqrt(max((0.5 * limit) ** 2 - (0.5 * base_diameter) ** 2, 0.0)) for limit in (start, end)]
        diameter = _rolled(rolls[0] + share * (rolls[1] - rolls[0]), base_diameter, file)
        z = np.full(count, place)
    else:
        kind = "lead"
        start, end = (_of_side(ranges[name], side) for name in ("ba", "be"))
        z = start + share * (end - start)
        given = np.array([place])
        diameter = np.full(count, (given if head["axis"] == "d" else _rolled(given, base_diameter, file))[0])
    known = deviation > _UNDEFINED
    return Trace(kind, flank, int(head["tooth"]), diameter[known], z[known], deviation[known])


def _of_side(values: FloatArray, side: int) -> float:
    return float(values[min(side, values.size - 1)])

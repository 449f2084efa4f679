"""The worn flanks as teeth that can be turned: data, controls and scripts of the view (extra ``report``).

plotly draws them. Its script lies in the page, compressed, and is unpacked by the reader's browser: nothing is
fetched. Without WebGL, without scripts and on paper the pictures below the view replace it.
"""

from __future__ import annotations

import base64
import gzip
import json
from functools import cache
from hashlib import sha256
from importlib import resources

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray, IntArray
from semiwear.plot.flank import WEAR_COLOURS, along_tooth
from semiwear.plot.style import need, step_name
from semiwear.report.markup import element, figure_text
from semiwear.report.packing import Packer
from semiwear.report.tooth_shape import ToothShape, tooth_shape
from semiwear.results.missing import away_from_edges, group_of
from semiwear.results.wearing import shown_bodies
from semiwear.untyped import Table

TURNING_EXTRA = "report"
"""Extra that installs the library of the view."""


_MOST_NODES, _MOST_STEPS = 9000, 16  # drawn of a body, always with the first and the last ones
_COLOURS = 24  # in a scale
_DRAWN_DEPTH = 0.15  # of the tooth's height: about the drawn depth of the greatest wear
_INSIDE = 1.03  # greatest ratio of Hertzian pressure to that of the run away from edges
_LOADED = 1e-6  # least load share of a loaded pair; below is rounding

_BY_PATTERN = "greatest pressure at each point in a mesh"
_BY_LINES = (
    "the greatest pressure of each roll position away from edges, distributed along its contact line by Hertz's law "
    "from the line load and the curvature of the unworn flanks"
)


def can_turn() -> bool:
    """Whether the library of the view is installed."""
    return bool(_library())


def script_hashes() -> tuple[str, ...]:
    """SHA-256 of the scripts that a page with a view runs, as a content security policy names them."""
    return tuple(
        f"'sha256-{base64.b64encode(sha256(text.encode()).digest()).decode()}'" for text in (_script(), _library())
    )


@cache
def _library() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        return ""
    return str(get_plotlyjs())


@cache
def _packed_library() -> str:
    return base64.b64encode(gzip.compress(_library().encode(), 9, mtime=0)).decode()


@cache
def _script() -> str:
    return resources.files("semiwear.report").joinpath("turning.js").read_text(encoding="utf-8")


def turning_flanks(tree: xr.DataTree) -> str:
    """The view of the worn flanks of a result, as HTML; empty without wear or without the library.

    Parameters
    ----------
    tree : DataTree
        With `/flank` and at least two wear steps.
    """
    steps = group_of(tree, "flank").sizes.get("wear_step", 1)
    if steps < 2 or not can_turn():
        return ""
    pack = Packer()
    view = _view(tree, pack)
    header = json.dumps(view, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return (
        f"{_controls(view)}"
        f'<script type="application/json" id="turning-told">{header}</script>'
        f'<script type="text/plain" id="turning-data">{pack.base64()}</script>'
        f'<script type="text/plain" id="turning-library">{_packed_library()}</script>'
        f"<script>{_script()}</script>"
    )


def _view(tree: xr.DataTree, pack: Packer) -> Table:
    """Data of the view for the script: texts and numbers, and descriptions of the packed arrays."""
    wear = need(tree, "flank", "wear_depth")
    steps = np.unique(np.linspace(0, wear.sizes["wear_step"] - 1, _MOST_STEPS).round().astype(int))
    bodies = shown_bodies(tree)
    return {
        "steps": [step_name(wear, int(step)) for step in steps],
        "bodies": [_body(tree, body, steps, pack) for body in bodies],
        "engagement": _engagement(tree, steps, pack),
    }


def _body(tree: xr.DataTree, body: str, steps: IntArray, pack: Packer) -> Table:
    flank, shape = tree["flank"].to_dataset().sel(body=body), tooth_shape(tree, body)
    rows, columns = _thinned(*shape.flank.shape[:2])
    wear = flank["wear_depth"].values[steps]
    pressure, meaning = _pressure(tree, body, shape)
    colours: list[Table] = [_quantity("wear", "Wear depth", "µm", WEAR_COLOURS, wear[:, rows][:, :, columns], pack)]
    if pressure is not None:
        chosen = pressure[steps][:, rows][:, :, columns]
        colours.append(_quantity("pressure", "Contact pressure", "MPa", "viridis", chosen, pack) | {"note": meaning})
    sliding = np.abs(flank["specific_sliding"].values)[None, rows][:, :, columns]
    note = "absolute specific sliding of the unworn flanks"
    colours.append(_quantity("sliding", "Specific sliding", "", "cividis", sliding, pack) | {"note": note})
    along, name = along_tooth(tree, body)
    ends = [f"{name} {figure_text(float(along.values[:, k].mean()), 3)} mm" for k in (0, -1)]
    height, lines = float(np.ptp(shape.flank[..., 2])), _loaded_lines(tree, shape.line, rows)
    return {
        "name": body,
        "ends": ends,
        "factors": _factors(height, 1e-3 * float(wear.max())),
        "flank": pack.add(shape.flank[rows][:, columns]),
        "normal": pack.add(shape.normal[rows][:, columns]),
        "back": pack.add(shape.back[rows][:, columns]),
        "fillet": pack.add(shape.fillet[:, columns]),
        "backFillet": pack.add(shape.back_fillet[:, columns]),
        "wear": colours[0]["values"],
        "quantities": colours,
        "line": None if lines is None else pack.add(lines[:, columns]),
        "load": None if lines is None else pack.add(_loads(tree, shape, steps)[..., columns]),
    }


def _thinned(profiles: int, faces: int) -> tuple[IntArray, IntArray]:
    """Rows and columns of the grid that are drawn."""
    share = min(1.0, (_MOST_NODES / (profiles * faces)) ** 0.5)
    rows, columns = (
        np.unique(np.linspace(0, n - 1, max(round(share * n), 2)).round().astype(int)) for n in (profiles, faces)
    )
    return rows, columns


def _quantity(name: str, title: str, units: str, colours: str, values: FloatArray, pack: Packer) -> Table:
    import matplotlib

    scale = matplotlib.colormaps[colours](np.linspace(0.0, 1.0, _COLOURS))
    return {
        "name": name,
        "title": title,
        "units": units,
        "greatest": float(values.max()) or 1.0,
        "colours": [matplotlib.colors.to_hex(colour) for colour in scale],
        "values": pack.add(values),
    }


def _factors(height: float, deepest: float) -> list[int]:
    """Factors by which the drawn wear can be enlarged; the last but one is the initial one."""
    if deepest <= 0.0:
        return [1]
    ratio = max(_DRAWN_DEPTH * height / deepest, 1.0)
    power = 10 ** int(np.floor(np.log10(ratio)))
    initial = max(digit * power for digit in (1, 2, 5) if digit * power <= ratio)
    return sorted({1, max(initial // 2, 1), initial, 2 * initial})


def _pressure(tree: xr.DataTree, body: str, shape: ToothShape) -> tuple[FloatArray | None, str]:
    """Greatest pressure at the points of a flank in a mesh, (wear_step, profile, face) [MPa], and its origin."""
    flank, engagement = group_of(tree, "flank"), group_of(tree, "engagement")
    if body == "gear" and "contact_pattern" in flank:
        return np.asarray(flank["contact_pattern"].values, float), _BY_PATTERN
    if shape.line is None or shape.hertz is None or "line_load" not in engagement:
        return None, ""
    load = np.asarray(engagement["line_load"].values, float)
    along_line = _along_lines(np.nan_to_num(away_from_edges(engagement).values), shape.hertz * np.sqrt(load))
    load, along_line = shape.at_stations(load), shape.at_stations(along_line)
    on_flank = np.zeros((load.shape[0], *shape.flank.shape[:2]))
    rows = np.arange(shape.flank.shape[0], dtype=float)
    for i in range(load.shape[-1]):
        loaded = np.flatnonzero((load[..., i] > 0.0).any(axis=0))
        order = loaded[np.argsort(shape.line[loaded, i], kind="stable")]
        if not order.size:
            continue
        for step, values in enumerate(along_line[:, order, i]):
            on_flank[step, :, i] = np.interp(rows, shape.line[order, i], values, left=0.0, right=0.0)
    return on_flank, _BY_LINES


def _along_lines(greatest: FloatArray, hertz: FloatArray) -> FloatArray:
    """Pressure along contact lines, (wear_step, roll, face) [MPa].

    Parameters
    ----------
    greatest : (wear_step, roll) array [MPa]
        Pressure of the run away from edges; 0 where only edges carry load.
    hertz : (wear_step, roll, face) array [MPa]
        Pressure from the line loads of the run and the curvature of the unworn flanks.

    Returns
    -------
    array
        `hertz` scaled so that its greatest value at each roll position is the pressure of the run, which is also the
        upper limit. Slices whose Hertzian pressure on unworn flanks is above that of the run lie at the ends, which
        are edges; they do not enter the scale.
    """
    inside = (hertz[0] <= _INSIDE * greatest[0][:, None]) | (greatest[0] == 0.0)[:, None]
    highest = np.max(hertz, axis=-1, where=inside, initial=0.0)
    ratio = np.divide(greatest, highest, out=np.zeros_like(greatest), where=highest > 0.0)
    return np.asarray(np.minimum(ratio[..., None] * hertz, greatest[..., None]))


def _loaded_rolls(tree: xr.DataTree) -> IntArray:
    """Indices of the roll positions that bear load; none without line loads."""
    engagement = group_of(tree, "engagement")
    if "line_load" not in engagement or "load_share" not in engagement:
        return np.zeros(0, dtype=int)
    return np.flatnonzero((engagement["load_share"].values > _LOADED).any(axis=0))


def _loaded_lines(tree: xr.DataTree, line: FloatArray | None, rows: IntArray) -> FloatArray | None:
    """Fractional rows, among the drawn ones, of the contact lines of loaded roll positions, (roll, face)."""
    rolls = _loaded_rolls(tree)
    if line is None or not rolls.size:
        return None
    return np.asarray(np.interp(line[rolls], rows, np.arange(rows.size)))


def _loads(tree: xr.DataTree, shape: ToothShape, steps: IntArray) -> FloatArray:
    """Line loads of the loaded roll positions at a flank's stations, (wear_step, roll, face) [N/mm]."""
    load = np.asarray(group_of(tree, "engagement")["line_load"].values[steps], float)
    return shape.at_stations(load)[:, _loaded_rolls(tree)]


def _engagement(tree: xr.DataTree, steps: IntArray, pack: Packer) -> Table | None:
    """Load share of the loaded roll positions; None without line loads."""
    engagement, rolls = group_of(tree, "engagement"), _loaded_rolls(tree)
    if not rolls.size:
        return None
    return {
        "roll": [f"{roll:+.2f}".replace("-", "−") for roll in engagement["roll_position"].values[rolls]],
        "share": pack.add(engagement["load_share"].values[steps][:, rolls]),
    }


def _controls(view: Table) -> str:
    """The view with its controls; hidden until the script has drawn it."""
    last = len(view["steps"]) - 1
    bodies = "".join(element("option", body["name"], value=str(k)) for k, body in enumerate(view["bodies"]))
    parts = [
        _labelled("Flank of", element("select", bodies, id="turning-body")) if len(view["bodies"]) > 1 else "",
        _labelled("Colours", element("select", "", id="turning-quantity")),
        _labelled("Wear drawn", element("select", "", id="turning-factor")),
        _labelled(
            "Wear step", f'<input type="range" id="turning-step" min="0" max="{last}" value="{last}">', "turning-when"
        ),
    ]
    if view["engagement"] is not None and any(body["line"] for body in view["bodies"]):
        most = len(view["engagement"]["roll"]) - 1
        rolls = f'<input type="range" id="turning-roll" min="0" max="{most}" value="{most // 2}">'
        parts.append(_labelled("Roll position", rolls, "turning-where"))
    turns = "".join(
        f'<button type="button" data-turn="{turn}" aria-label="{name}">{sign}</button>'
        for turn, name, sign in (
            ("left", "Turn left", "←"),
            ("right", "Turn right", "→"),
            ("up", "Turn up", "↑"),
            ("down", "Turn down", "↓"),
            ("in", "Nearer", "+"),
            ("out", "Farther", "−"),
            ("home", "Initial view", "⟲"),
        )
    )
    return (
        '<figure class="turning" id="turning" hidden>'
        '<div id="turning-view" tabindex="0" role="application" aria-label="Worn tooth in three dimensions"'
        ' aria-describedby="turning-told-aloud turning-help"></div>'
        f'<div class="turns" role="group" aria-label="Turn the tooth">{turns}</div>'
        f'<div class="controls">{"".join(parts)}</div>'
        '<figcaption><p id="turning-told-aloud" role="status"></p>'
        '<p id="turning-help">Drag to turn, or use the arrow keys, + and − while the picture has the focus. Dashed: '
        "edges of the unworn flank. Bright: the loaded part of the contact line. Roll positions are in base pitches "
        "from the pitch point.</p></figcaption></figure>"
    )


def _labelled(text: str, control: str, output: str = "") -> str:
    shown = f'<output id="{output}"></output>' if output else ""
    return f"<label><span>{text}</span>{control}{shown}</label>"

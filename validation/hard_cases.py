"""Hard cases by name: scenes at the limits of geometry, load, material, placement and wear, and what came of them.

Grids are small and teeth mostly rigid, so that a case takes a fraction of a second. The tests' own hard cases are
changes of the same small scene.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import semiwear as sw
from semiwear.meshing.deviation_grid import write_deviation_grid
from semiwear.results.missing import why_missing
from semiwear.scene import Placement, Scene
from tests.scenes import CONFORMAL, NOMINAL_TORQUE, SHARP, UNTIL_MESHES, scene_of

SMALL_CHANGE = 1e-6
BALANCE = 1e-9
COMPLEMENTARITY = {"line": 1e-9, "patch": 1e-6}


# ---- examples


@dataclass(frozen=True)
class HardExample:
    """A hard case.

    Attributes
    ----------
    kind, name : str
        What is hard, and which of its cases this is.
    changes : mapping
        Fields of the small scene.
    placement : Placement or None
    wear : callable or None
        From the shape (profile, face) of the flank grid to wear depths [um].
    runs : bool
        Whether flanks are worn, or loaded once.
    refused : bool
        Whether an error is what a user should get.
    noise : float
        Of a measured flank [um]; 0 for none.
    positions : tuple of float or None
        Mesh positions; None for those of the small scene.
    neighbours : bool
        Whether it is solved again with a little more torque, and on finer grids.
    slow : bool
        Whether it takes many seconds, and is left out of a quick report.
    """

    kind: str
    name: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    placement: Placement | None = None
    wear: Callable[[tuple[int, int]], np.ndarray] | None = None
    runs: bool = False
    refused: bool = False
    noise: float = 0.0
    positions: tuple[float, ...] | None = None
    neighbours: bool = True
    slow: bool = False

    @contextmanager
    def scene(self, *more: Mapping[str, Any]) -> Iterator[Scene]:
        """The scene, while the file of its measured flank is there."""
        with tempfile.TemporaryDirectory() as folder:
            measured = {}
            if self.noise:
                path = Path(folder) / "measured.nc"
                random = np.random.default_rng(1)
                write_deviation_grid(
                    path,
                    np.linspace(0.0, 1.0, 40),
                    np.linspace(0.0, 1.0, 25),
                    self.noise * random.standard_normal((40, 25)),
                )
                measured = {"effects.modification.gear.file": str(path)}
            yield scene_of(self.changes, measured, *more, wears=self.runs)

    def solve(self, *more: Mapping[str, Any]) -> xr.DataTree:
        """The result."""
        with self.scene(*more) as scene:
            if self.runs:
                return sw.simulate(scene)
            shape = scene.numerics.profile_points, scene.numerics.face_slices
            wear = None if self.wear is None else self.wear(shape)
            return sw.loaded_contact(scene, self.positions, wear, self.placement)


def _torque(factor: float) -> dict[str, Any]:
    return {"operation.pinion_torque_Nm": factor * NOMINAL_TORQUE}


def _teeth(pinion: int, shaper: int, gear: int, angle: float) -> dict[str, Any]:
    """Pairs of the shipped module; every other length in proportion."""
    radius = 0.5 * 6.35 * gear
    derived = ["pinion_centre", "pinion_addendum", "gear_addendum", "shaper_addendum", "rack_addendum"]
    derived += ["shaper_tip_radius", "rack_tip_radius", "pinion_bore_radius", "gear_rim_thickness"]
    return {
        "gear_pair.pinion_teeth": pinion,
        "gear_pair.shaper_teeth": shaper,
        "gear_pair.gear_teeth": gear,
        "gear_pair.pressure_angle_deg": angle,
        "gear_pair.gear_inner_radius_mm": radius * 0.985,
        "gear_pair.gear_outer_radius_mm": radius * 1.025,
        "gear_pair.pinion_face_width_mm": 0.04 * radius,
        **{f"gear_pair.{name}_mm": None for name in derived},
        **dict.fromkeys(SHARP, 0.05),
    }


def _worn(meshes: float, steps: int, **numerics: Any) -> dict[str, Any]:
    return (
        UNTIL_MESHES
        | {"wear.until.meshes": meshes, "numerics.wear_steps": steps}
        | {f"numerics.{name}": value for name, value in numerics.items()}
    )


HARD_EXAMPLES: tuple[HardExample, ...] = (
    HardExample("undercut limit", "inner radius 465.174 mm", {"gear_pair.gear_inner_radius_mm": 465.174}),
    HardExample("undercut limit", "inner radius 465.17 mm", {"gear_pair.gear_inner_radius_mm": 465.17}, refused=True),
    HardExample("pointing limit", "half-thickness 0.37 mm at 560 mm, the shipped gear"),
    HardExample(
        "pointing limit",
        "outer radius 569.32 mm, sharp tip",
        {"gear_pair.gear_outer_radius_mm": 569.32, "gear_pair.gear_tip_edge_radius_mm": 0.0},
    ),
    HardExample("pointing limit", "outer radius 569.34 mm", {"gear_pair.gear_outer_radius_mm": 569.34}, refused=True),
    HardExample("pinion tip on the gear fillet", "addendum 7.356 mm", {"gear_pair.pinion_addendum_mm": 7.356}),
    HardExample(
        "pinion tip on the gear fillet", "addendum 7.357 mm", {"gear_pair.pinion_addendum_mm": 7.357}, refused=True
    ),
    HardExample("heel and toe", "pinion turned by 20 mrad, inwards", placement=Placement(pinion_slope_mrad=20.0)),
    HardExample("heel and toe", "pinion turned by 20 mrad, outwards", placement=Placement(pinion_slope_mrad=-20.0)),
    HardExample("heel and toe", "pinion 100 mm beside", placement=Placement(axial_pinion_mm=100.0), refused=True),
    HardExample("corner contact", "sharp edges", SHARP),
    HardExample(
        "corner contact", "sharp edges, shaft angle 3 mrad off", SHARP, Placement(shaft_angle_error_mrad=3.0)
    ),
    HardExample("corner contact", "tips alone, pinion drawn back by 11 mm", placement=Placement(axial_gear_mm=11.0)),
    HardExample("torque", "1e-6 times nominal", _torque(1e-6)),
    HardExample("torque", "1e-3 times nominal", _torque(1e-3)),
    HardExample("torque", "10 times nominal", _torque(10.0)),
    HardExample("torque", "100 times nominal", _torque(100.0)),
    HardExample("near-conformal flanks", "shaper of 26 teeth", CONFORMAL),
    HardExample(
        "near-conformal flanks", "the same, tip rounding too large", {"gear_pair.shaper_teeth": 26}, refused=True
    ),
    HardExample(
        "localised contact",
        "shaper of 60 teeth",
        {
            "gear_pair.shaper_teeth": 60,
            "gear_pair.gear_inner_radius_mm": 495.0,
            "gear_pair.gear_outer_radius_mm": 520.0,
        },
    ),
    HardExample("zero sliding at the pitch line", "worn for 1e8 meshes", _worn(1e8, 2), runs=True),
    HardExample("pairs change within a roll step", "8 positions a cycle", {"numerics.roll_positions": 8}),
    HardExample(
        "pairs change within a roll step", "3 positions a cycle", {"numerics.roll_positions": 3}, refused=True
    ),
    HardExample(
        "deep wear",
        "2 mm off three quarters of the face: the nominal path carries nothing",
        wear=lambda shape: 2000.0 * (np.arange(shape[1]) < 0.76 * shape[1]) * np.ones(shape),
    ),
    HardExample(
        "deep wear",
        "a ridge 0.2 mm high",
        wear=lambda shape: 200.0 * np.abs(np.linspace(-1.0, 1.0, shape[0]))[:, None] * np.ones(shape),
    ),
    HardExample("wear steps too large", "a whole life in one implicit step", _worn(9e9, 1), runs=True),
    HardExample("wear steps too large", "a thousand lives in two", _worn(6e12, 2), runs=True, refused=True),
    HardExample(
        "wear steps too large",
        "a thousand lives in two, explicit",
        _worn(6e12, 2, wear_scheme="explicit"),
        runs=True,
        refused=True,
    ),
    HardExample("noisy measured flank", "noise of 2 um", noise=2.0),
    HardExample("noisy measured flank", "noise of 20 um", noise=20.0),
    HardExample("slices", "7", {"numerics.face_slices": 7}),
    HardExample("slices", "100", {"numerics.face_slices": 100}),
    HardExample(
        "slices",
        "1000 of 0.08 mm",
        {"numerics.face_slices": 1000, "numerics.profile_points": 21},
        positions=(0.0,),
        neighbours=False,
    ),
    HardExample(
        "slices",
        "3000 of 0.03 mm",
        {"numerics.face_slices": 3000, "numerics.profile_points": 21},
        positions=(0.0,),
        neighbours=False,
        slow=True,
    ),
    HardExample("mirrored flanks", "coast", {"operation.loaded_flank": "coast"}),
    HardExample("material contrast", "gear of 500 MPa", {"material.gear.youngs_modulus_MPa": 500.0}),
    HardExample("material contrast", "gear of 1.5e6 MPa", {"material.gear.youngs_modulus_MPa": 1.5e6}),
    HardExample(
        "material contrast",
        "gear of 500 MPa, 100 times nominal torque",
        {"material.gear.youngs_modulus_MPa": 500.0} | _torque(100.0),
        refused=True,
    ),
    HardExample(
        "tooth numbers",
        "12 and 40",
        _teeth(12, 13, 40, 30.0)
        | {
            "gear_pair.rack_tip_radius_mm": 0.5,
            "gear_pair.shaper_addendum_mm": 7.0,
            "gear_pair.shaper_tip_radius_mm": 0.1,
        }
        | _torque(0.1),
    ),
    HardExample("tooth numbers", "60 and 300", _teeth(60, 62, 300, 25.0)),
    HardExample("tooth numbers", "12 and 40, 20 degrees: undercut", _teeth(12, 13, 40, 20.0), refused=True),
)


# ---- what came of them


@dataclass(frozen=True)
class Outcome:
    """What came of a hard case at one fidelity.

    Attributes
    ----------
    example : HardExample
    fidelity : str
    error : str
        Of the refusal; empty where it was solved.
    finite, non_negative : bool
        No number that is none; no tension, and no wear below zero.
    balance, complementarity : float
        Residuals: of the torque, relative; of gap times pressure, relative.
    pressure : float [MPa]
        Greatest, edges included.
    continuity : float
        Greatest change of a line load over the greatest line load, over the change of torque that made it.
    refinements : tuple of float
        Greatest change of a load share each time that slices and flank points are doubled.
    """

    example: HardExample
    fidelity: str
    error: str = ""
    finite: bool = True
    non_negative: bool = True
    balance: float = 0.0
    complementarity: float = 0.0
    pressure: float = 0.0
    continuity: float = float("nan")
    refinements: tuple[float, ...] = ()

    @property
    def as_it_should_be(self) -> bool:
        """Refused where it should be, otherwise solved: finite, not negative, balanced, complementary."""
        if self.example.refused or self.error:
            return self.example.refused == bool(self.error)
        held = self.balance <= BALANCE and self.complementarity <= COMPLEMENTARITY[self.fidelity]
        return self.finite and self.non_negative and held


def attempt(example: HardExample, fidelity: str, doublings: int = 1) -> Outcome:
    """Solve a hard case, and it again with a little more torque and on finer grids.

    Parameters
    ----------
    example : HardExample
    fidelity : str
    doublings : int
        How often slices and flank points are doubled.
    """
    at = {"numerics.fidelity": fidelity}
    try:
        tree = example.solve(at)
    except sw.SceneError as error:
        return Outcome(example, fidelity, error=str(error.problems[0]))
    except sw.ConvergenceError as error:
        return Outcome(example, fidelity, error=str(error))
    engagement, diagnostics = tree["engagement"].to_dataset(), tree["diagnostics"].to_dataset()
    groups = [tree[name].to_dataset() for name in ("engagement", "mesh_cycle", "flank") if name in tree.children]
    finite = all(
        bool(np.isfinite(values).all()) or why_missing(values) not in ("", "not known")
        for data in groups
        for values in data.data_vars.values()
        if values.dtype.kind == "f"
    )
    least = [float(engagement[name].min()) for name in ("line_load", "load_share", "contact_pressure_max_edge")]
    least += [float(data["wear_depth"].min()) for data in groups if "wear_depth" in data]
    again = example.neighbours and not example.runs
    return Outcome(
        example,
        fidelity,
        finite=finite,
        non_negative=min(least) >= 0.0,
        balance=float(diagnostics["load_balance_residual"].max()),
        complementarity=float(diagnostics["complementarity_residual"].max()),
        pressure=max(float(engagement[f"contact_pressure_max{end}"].max()) for end in ("", "_edge")),
        continuity=_continuity(example, at, engagement) if again else float("nan"),
        refinements=_refinements(example, at, engagement, doublings) if again else (),
    )


def _continuity(example: HardExample, at: Mapping[str, Any], engagement: xr.Dataset) -> float:
    """How line loads answer a little more torque: 1 where they are in proportion."""
    with example.scene(at) as scene:
        torque = scene.operation.pinion_torque_Nm
    tree = example.solve(at, {"operation.pinion_torque_Nm": torque * (1.0 + SMALL_CHANGE)})
    more = tree["engagement"].to_dataset()
    load = engagement["line_load"].values
    return float(np.abs(more["line_load"].values - load).max()) / float(load.max()) / SMALL_CHANGE


def _refinements(
    example: HardExample, at: Mapping[str, Any], engagement: xr.Dataset, doublings: int
) -> tuple[float, ...]:
    """How load shares answer finer grids."""
    with example.scene(at) as scene:
        slices, points = scene.numerics.face_slices, scene.numerics.profile_points
    before, changes = engagement["load_share"].values, []
    for _ in range(doublings):
        slices, points = 2 * slices - 1, 2 * points - 1
        finer = {"numerics.face_slices": slices, "numerics.profile_points": points}
        share = example.solve(at, finer)["engagement"].to_dataset()["load_share"].values
        changes.append(float(np.abs(share - before).max()))
        before = share
    return tuple(changes)

"""Which pressures count as an edge's: the same in finite elements and in the core."""

from dataclasses import fields, replace

import numpy as np
import pytest

import semiwear as sw
from fem_reference.edge_rule import beside_edges, reference_half_width
from fem_reference.kinematics import PairKinematics
from fem_reference.rigid_lines import RigidFlank
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.slice_pressure import SlicePressures

ROLLS = np.array([-0.9, -0.67, -0.3, 0.0, 0.4, 0.8])
WIDTH = 0.4  # mm, of the made-up contact
OFFSETS = np.linspace(-2.5, 2.5, 501)  # mm across the line


@pytest.fixture(scope="module")
def teeth(shipped: sw.Scene) -> LoadedTeeth:
    rigid = shipped.replace({"numerics.tooth_compliance": "rigid", "numerics.face_slices": 121})
    return sw.plan(rigid).loaded_teeth(None, ROLLS)


@pytest.fixture(scope="module")
def pair(shipped: sw.Scene) -> PairKinematics:
    return PairKinematics(shipped)


def crown(face: np.ndarray, offset: np.ndarray, middle: float, edge: float) -> np.ndarray:
    """Pressures of a made-up contact: an ellipsoid along the line, and a spot of `edge` times its height on it."""
    along = np.maximum(1.0 - ((face - middle) / 18.0) ** 2, 0.0)
    across = np.sqrt(np.maximum(1.0 - (offset / WIDTH) ** 2, 0.0))
    ridge = edge * np.exp(-((face - middle - 4.0) ** 2) / 2.0)
    return 1000.0 * along * (across + ridge * np.exp(-((offset / 0.3) ** 2)))


class MadeUp:
    """A fidelity whose pressures are made up."""

    def __init__(self, teeth: LoadedTeeth, middle: float, edge: float):
        self.lines, self.middle, self.edge = teeth.lines, middle, edge

    def pressures(self, problem, loads, worn, margin):
        lines = self.lines
        pressure = crown(lines.face[None, :, None], OFFSETS, self.middle, self.edge)
        place = lines.profile[..., None] + OFFSETS / lines.spacing[..., None]
        on = (place >= lines.low[..., None]) & (place <= lines.high[..., None])
        first, last = lines.low + margin / lines.spacing, lines.high - margin / lines.spacing
        inside = (place >= first[..., None]) & (place <= last[..., None])
        pressure = np.where(on, pressure, 0.0) * np.ones_like(place)
        return SlicePressures(
            np.where(inside, pressure, 0.0).max(axis=-1), lines.profile, np.where(inside, 0.0, pressure).max(axis=-1)
        )


def test_reference_length_is_the_cores(teeth: LoadedTeeth, pair: PairKinematics) -> None:
    assert reference_half_width(pair) == pytest.approx(teeth.half_width, rel=2e-3)


@pytest.mark.parametrize("times", [0.02, 10.0])
def test_reference_length_grows_with_the_gears(shipped: sw.Scene, pair: PairKinematics, times: float) -> None:
    table = shipped.gear_pair
    lengths = {
        f"gear_pair.{name}": times * getattr(table, name)
        for name in (one.name for one in fields(table))
        if name.endswith("_mm")
    }
    lengths |= {"wear.control_point.radius_mm": times * 508.0, "wear.control_point.height_mm": times * -4.0}
    torque = times**3 * shipped.operation.pinion_torque_Nm
    grown = shipped.replace({**lengths, "operation.pinion_torque_Nm": torque})
    assert reference_half_width(PairKinematics(grown)) == pytest.approx(times * reference_half_width(pair), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("middle", [484.0, 508.0, 520.0])
@pytest.mark.parametrize("edge", [0.0, 1.5])
def test_both_part_pressures_alike(teeth: LoadedTeeth, pair: PairKinematics, middle: float, edge: float) -> None:
    """Greatest pressure inside and at the border of a made-up contact, at roll positions clear of edges and not."""

    class State:
        loads = coarse = None

    found = replace(teeth, fidelity=MadeUp(teeth, middle, edge)).pressures(State())
    rolls = {round(float(roll), 6): k for k, roll in enumerate(teeth.lines.roll)}
    apart = 0
    for roll in ROLLS:
        k, line = rolls[round(float(roll), 6)], RigidFlank(pair).line(float(roll))
        face = np.repeat(teeth.lines.face, OFFSETS.size)
        offset = np.tile(OFFSETS, teeth.lines.face.size)
        # the made-up pressure lies about the core's line
        profile = np.repeat(teeth.lines.profile[k], OFFSETS.size) + offset / np.repeat(
            teeth.lines.spacing[k], OFFSETS.size
        )
        met = pair.meeting(face, profile, float(roll))
        on = (
            (profile <= pair.gear.tip_profile(face) - pair.edge_insets(face).gear_tip)
            & (met.pinion_profile <= pair.pinion_profile_limits[1] - pair.edge_insets(face).pinion_tip)
            & (profile >= pair.gear.root_profile)
        )
        pressure = np.where(on, crown(face, offset, middle, edge), 0.0)
        beside = beside_edges(
            pair, teeth.half_width, line, face, profile, met.pinion_face, met.pinion_profile, pressure
        )
        inner, border = (np.where(part, pressure, 0.0).max() for part in (~beside, beside))
        assert inner == pytest.approx(found.inner[k].max(), rel=0.03, abs=1.0), roll
        assert border == pytest.approx(found.border[k].max(), rel=0.03, abs=1.0), roll
        apart += bool(border > 0.0)
    assert apart > 0

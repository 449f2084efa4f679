"""Deposit of wear from pressures at a few roll positions, against the swept line and its limit at the pitch line."""

from types import SimpleNamespace

import numpy as np
import pytest

import semiwear as sw
from fem_reference.deposit import Deposit, line_offsets, line_pressures, marched
from fem_reference.edge_rule import reference_half_width
from fem_reference.kinematics import PairKinematics
from fem_reference.passage import Passage
from fem_reference.rigid_lines import RigidFlank
from fem_reference.wear import face_stations, flank_profile

LOAD, HALF = 400.0, 0.4  # N/mm, mm of profile coordinate


@pytest.fixture(scope="module")
def fresh(small: sw.Scene) -> RigidFlank:
    return RigidFlank(PairKinematics(small), stations=41)


@pytest.fixture(scope="module")
def passage(fresh: RigidFlank) -> Passage:
    return Passage.of(fresh, -0.6, 0.6)


@pytest.fixture(scope="module")
def swept(fresh: RigidFlank) -> tuple[Deposit, np.ndarray]:
    """Depth over k of a semi-elliptic contact that passes the pitch point with a load that never changes."""
    rolls = np.arange(-7.0, 8.0) / 18.0
    offsets = line_offsets(fresh.pair)
    shape = np.sqrt(np.maximum(1.0 - (offsets / HALF) ** 2, 0.0))
    shape /= shape.sum() * (offsets[1] - offsets[0])
    deposit = Deposit.of(fresh, rolls)
    pressures = []
    for roll in rolls:
        line = fresh.line(float(roll))
        spacing = np.interp(deposit.face, line.face, line.spacing)
        pressures.append(LOAD * shape / spacing[:, None])
    return deposit, deposit(np.stack(pressures))


def test_deposit_is_the_swept_line(fresh: RigidFlank, passage: Passage, swept: tuple[Deposit, np.ndarray]) -> None:
    """q |v_s|/v_n where a line passes whole: away from the pitch line, from the borders and inside the stretch."""
    deposit, depth = swept
    height = deposit.profile - fresh.pair.gear.profile_from_height(
        deposit.face, fresh.pair.pitch_height(deposit.face)
    )
    # beyond 530 mm the pinion's tip holds the lines of these roll positions
    inside = (deposit.face > 485.0) & (deposit.face < 530.0)
    passed = (np.abs(passage.roll) < 0.25) & (np.abs(height) > 2.0 * HALF) & inside
    assert passed.sum() > 400
    ratio = depth[passed] / (LOAD * passage.specific_sliding[passed])
    assert ratio.mean() == pytest.approx(1.0, abs=0.005)
    assert np.abs(ratio - 1.0).max() < 0.02


def test_deposit_at_the_pitch_line(fresh: RigidFlank, passage: Passage, swept: tuple[Deposit, np.ndarray]) -> None:
    """Zero sliding in the middle of the contact still leaves q (4 b/(3 pi)) |dv_s/ds| / v_n under a semi-ellipse."""
    deposit, depth = swept
    column = int(np.argmin(np.abs(deposit.face - fresh.pair.gear.pitch_radius)))
    profile, sliding = deposit.profile[:, column], passage.specific_sliding[:, column]
    pitch = int(np.argmin(np.where(np.isfinite(passage.roll[:, column]), sliding, np.inf)))
    slope = (sliding[pitch + 8] + sliding[pitch - 8]) / (profile[pitch + 8] - profile[pitch - 8])
    assert depth[pitch, column] == pytest.approx(LOAD * 4.0 * HALF / (3.0 * np.pi) * slope, rel=0.03)


def test_finer_instants_change_nothing(fresh: RigidFlank) -> None:
    rolls = np.arange(-1.0, 2.0) / 18.0
    narrow = (
        np.exp(-((line_offsets(fresh.pair) / 0.2) ** 2)) * np.array([0.0, 1.0, 0.0])[:, None, None] * np.ones((31, 1))
    )
    coarse, fine = (Deposit.of(fresh, rolls, steps=steps)(narrow) for steps in (8, 24))
    assert np.abs(coarse - fine).max() < 0.01 * fine.max()


def test_marched_is_the_deposit(fresh: RigidFlank) -> None:
    """Fine roll steps summed in place, and every fourth of them carried on between, under a load that grows."""
    rolls = np.arange(-8.0, 9.0) / 72.0
    shape = np.maximum(
        1.0 - (line_offsets(fresh.pair) / 0.5) ** 2, 0.0
    )  # smooth enough for the sum, unlike a semi-ellipse
    pressures = (1.0 + 3.0 * rolls)[:, None, None] * shape * np.ones((31, 1))
    depth, whole = marched(fresh, rolls, pressures)
    whole &= face_stations(fresh.pair) < 530.0
    carried = Deposit.of(fresh, rolls[::4])(pressures[::4])
    assert whole.sum() > 100
    assert np.abs(depth - carried)[whole].max() < 0.01 * depth.max()
    assert not whole[(passed_by(fresh, -0.2) | passed_by(fresh, 0.2))].any()


def passed_by(fresh: RigidFlank, roll: float) -> np.ndarray:
    """Points near the line of a roll position outside the stretch."""
    line = fresh.line(roll)
    stations = face_stations(fresh.pair)
    profile = flank_profile(fresh.pair, stations)
    return np.abs(profile - np.interp(stations, line.face, line.profile)) < 0.05


@pytest.mark.parametrize("torque", [1600.0, 1.0])
def test_pressures_of_light_loads_are_not_lost_between_the_places_where_they_are_held(
    small: sw.Scene, torque: float
) -> None:
    """Semi-elliptic contacts as wide as Hertz makes them keep their shape, wherever they stand beside the line."""
    fresh = RigidFlank(PairKinematics(small.replace({"operation.pinion_torque_Nm": torque})), stations=41)
    line, half = fresh.line(0.3), reference_half_width(fresh.pair)
    across = np.linspace(-1.3, 1.3, 27)
    for aside in (0.0, 0.31 * half, 2.47 * half):
        face, offset = np.meshgrid(face_stations(fresh.pair), half * across + aside, indexing="ij")
        profile = offset + np.interp(face, line.face, line.profile)
        pressure = np.sqrt(np.maximum(1.0 - across**2, 0.0)) + 0.0 * face
        contact = SimpleNamespace(pressure=pressure.ravel(), force=pressure.ravel())
        found = SimpleNamespace(face=face.ravel(), profile=profile.ravel(), line=line, contact=contact)
        held = line_pressures(found, fresh.pair, fresh)
        offsets = line_offsets(fresh.pair)
        area = held.sum(axis=1) * (offsets[1] - offsets[0])
        assert area == pytest.approx(0.5 * np.pi * half * held.max(axis=1), rel=0.02)
        assert area.min() > 0.0

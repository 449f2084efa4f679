"""Parts of the search for designs: the region, what a surrogate's best is, limits as seen, and finer grids."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from semiwear.optimise.correction import Correction
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Aim, Design, Designs
from semiwear.optimise.fine import search_finely
from semiwear.optimise.quantity import Limit, quantity_of
from semiwear.optimise.search import Goal, _about, _best_of, _next, _Region, best, finite_of, scan, search, values_of
from semiwear.optimise.space import space_of
from tests.scenes import SHIPPED

module, fine = (import_module(f"semiwear.optimise.{name}") for name in ("search", "fine"))
RELIEF = "effects.modification.gear.tip_relief_um"
SHAPE, OTHER = (f"effects.modification.{body}.relief_shape" for body in ("pinion", "gear"))
PLANE = space_of(SHIPPED, {"effects.modification.pinion.tip_relief_um": (0, 60), RELIEF: (0, 60)})
WEAR, SHARE, EFFICIENCY = (
    quantity_of("minimise", name, []) for name in ("wear_depth_max", "load_share_max", "mesh_efficiency")
)
FREE = Goal(0, np.zeros(0))


class Tried(Designs):
    """Designs whose aims and limited quantities are functions of place and resolution."""

    def __init__(
        self, function: Callable[[np.ndarray, str], tuple[Sequence[float], Sequence[float]]],
        aims: tuple[Aim, ...] = (Aim(WEAR),), limits: tuple[Limit, ...] = (), space=PLANE,
    ) -> None:  # fmt: skip
        super().__init__(SHIPPED, space, aims, limits, 0, lambda design: None)
        self.function = function

    def solved(self, places, resolution):
        found = []
        for place in places:
            aims, limited = self.function(place, resolution)
            found.append(Design(np.asarray(place), resolution, np.asarray(aims, float), np.asarray(limited, float)))
        self.tried += found
        return found


# ---------------------------------------------------------------------- the region


@pytest.mark.parametrize(
    "before, event, after",
    [
        ((0.1, 0.01), {"better": True}, (0.15, 0.005)),
        ((0.2, 0.01), {"better": True}, (0.25, 0.005)),
        ((0.1, 0.01), {}, (0.05, 0.005)),
        ((0.1, 0.0), {"broken": True}, (0.05, 0.002)),
        ((0.1, 0.004), {"broken": True, "better": True}, (0.15, 0.008)),
        ((0.1, 0.02), {"broken": True}, (0.05, 0.03)),
        ((0.1, 0.01), {"far": True}, (0.1, 0.01)),
        ((0.1, 0.01), {"far": True, "better": True, "broken": True}, (0.25, 0.01)),
    ],
)
def test_a_region_grows_with_success_and_its_margin_with_failure(before, event, after):
    found = _Region(*before).after(**({"better": False, "far": False, "broken": False} | event))
    assert (found.radius, found.margin) == pytest.approx(after)


def test_a_search_without_success_begins_anew_elsewhere_until_nothing_lies_there(monkeypatch):
    designs, heard = Tried(lambda place, _: ([place[0]], [])), []
    designs.solved([np.array([0.5, 0.5])], COARSE)

    def worse(_, goal, centre, region, step):
        heard.append((centre[0], region.radius, step))
        return np.array([0.9, 0.5])

    monkeypatch.setattr(module, "_next", worse)
    found = search(designs, FREE, 100)
    assert found.point.tolist() == [0.5, 0.5]
    # the region is halved at every design but at those far away, until it is less than 0.002
    first, second = [0, 1, 2, 3, 3, 4, 5, 6, 6, 7], [0, 1, 1, 2, 3, 4, 4, 5, 6, 7]
    assert [radius for _, radius, _ in heard] == pytest.approx(0.25 / 2.0 ** np.array(first + second))
    assert [centre for centre, _, _ in heard] == 10 * [0.5] + 10 * [0.9]
    assert [step for _, _, step in heard] == list(range(20))
    assert len(designs.tried) == 1 + 9 + 9  # at the end of a region nothing is tried


def test_a_limit_that_is_just_kept_asks_for_no_margin(monkeypatch):
    """Designs on the limit, twice beyond it, far away (which says nothing of the margin), and within it again."""
    designs = Tried(lambda place, _: ([1.0], [place[0]]), limits=(Limit(SHARE, 0.5, True),))
    designs.solved([np.array([0.9, 0.5])], COARSE)
    places, margins = iter([0.5, 0.6, 0.7, 0.4, 0.4, 0.4]), []

    def scripted(_, goal, centre, region, step):
        margins.append(region.margin)
        return np.array([next(places), 0.5])

    monkeypatch.setattr(module, "_next", scripted)
    search(designs, Goal(0, np.array([0.5])), 6)
    assert margins == pytest.approx([0.0, 0.0, 0.002, 0.004, 0.004, 0.002])


def scripted(
    monkeypatch: pytest.MonkeyPatch, places: Sequence[Sequence[float] | None]
) -> list[tuple[float, _Region]]:
    """Searches whose next designs are these, and no more; returns centres and regions that they are asked for."""
    heard, left = [], iter(places)

    def following(_, goal, centre, region, step):
        heard.append((float(centre[0]), region))
        place = next(left, None)
        return None if place is None else np.array(place)

    monkeypatch.setattr(module, "_next", following)
    return heard


def test_a_region_in_which_there_is_no_design_ends_at_once(monkeypatch):
    designs = Tried(lambda place, _: ([place[0]], []))
    designs.solved([np.array([place, 0.5]) for place in (0.9, 0.1, 0.5)], COARSE)
    heard = scripted(monkeypatch, [])
    assert search(designs, FREE, 10).point[0] == 0.1
    assert [centre for centre, _ in heard] == [0.1, 0.5, 0.9] and len(designs.tried) == 3


def test_a_margin_is_kept_where_a_search_begins_anew(monkeypatch):
    designs = Tried(lambda place, _: ([1.0], [place[0]]), limits=(Limit(SHARE, 0.5, True),))
    designs.solved([np.array([0.4, 0.5]), np.array([0.4, 0.9])], COARSE)
    heard = scripted(monkeypatch, [[0.6, 0.5], None])
    search(designs, Goal(0, designs.bounds), 3)
    assert [region for _, region in heard] == [_Region(0.25), _Region(0.125, 0.002), _Region(0.25, 0.002)]


def test_a_design_beside_one_that_ended_a_search_is_no_success(monkeypatch):
    """However good it is; one elsewhere is, and the region moves there."""
    designs = Tried(lambda place, _: ([place[0]], []))
    designs.solved([np.array([0.2, 0.5]), np.array([0.8, 0.5])], COARSE)
    heard = scripted(monkeypatch, [None, [0.25, 0.5], [0.5, 0.5]])
    search(designs, FREE, 4)
    assert [centre for centre, _ in heard] == [0.2, 0.8, 0.8, 0.5]
    assert [region.radius for _, region in heard] == pytest.approx([0.25, 0.25, 0.125, 0.1875])


def test_a_scan_holds_the_scene_itself_and_fills_the_space_evenly():
    """Of sixteen designs one lies in each sixteenth of every range; as many as asked for, or more."""
    torque = "operation.pinion_torque_Nm"
    given = SHIPPED.operation.pinion_torque_Nm
    space = space_of(SHIPPED, {torque: (0.8 * given, 1.8 * given), RELIEF: (0, 60)})
    designs = Tried(lambda place, _: ([0.0], []), space=space)
    found = scan(designs, 12)
    assert found[0].point == pytest.approx([0.2, 0.5])
    rest = np.array([design.point for design in found[1:]])
    for column in rest.T:
        assert sorted((16 * column).astype(int)) == list(range(16))


# ---------------------------------------------------------------------- the next design


def known(function: Callable[[np.ndarray], float], places: np.ndarray) -> Tried:
    designs = Tried(lambda place, _: ([function(place)], []))
    designs.solved(list(places), COARSE)
    return designs


def test_the_next_design_is_the_best_of_its_region_and_of_smaller_ones_about_it():
    """Downhill on a plane: by the radius, and by 0.3 of each step before, three times."""
    centre, radius = np.array([0.6, 0.6]), 0.1
    places = np.vstack([centre, np.random.default_rng(0).uniform(size=(8, 2))])
    found = _next(known(lambda place: place.sum(), places), FREE, centre, _Region(radius), 0)
    assert found is not None
    reach = radius * (1.0 + 0.3 + 0.09 + 0.027)
    assert np.all(centre - found <= reach + 1e-12) and (centre - found).sum() > 1.8 * reach


def test_a_design_too_near_to_what_is_known_is_not_tried():
    """The bottom of a bowl that is known: the next design keeps a tenth of the radius away from it."""
    bottom = np.array([0.5, 0.5])
    places = np.vstack([bottom, np.random.default_rng(1).uniform(size=(30, 2))])
    found = _next(known(lambda place: ((place - bottom) ** 2).sum(), places), FREE, bottom, _Region(0.2), 0)
    assert found is not None
    assert 0.02 <= np.abs(found - bottom).max() < 0.05


def test_every_fourth_design_is_far_from_what_is_known():
    """Although the aim is least in the corner where all are known; of far ones it is the best."""
    places = 0.2 * np.random.default_rng(2).uniform(size=(12, 2))
    found = _next(known(lambda place: place.sum(), places), FREE, places[0], _Region(0.1), 3)
    assert found is not None
    distance = np.abs(found - places).max(axis=1).min()
    assert 0.4 <= distance < 0.55 and found.min() < 0.1


def test_designs_far_away_are_others_each_time():
    """Where nothing was learnt in between."""
    places = 0.2 * np.random.default_rng(2).uniform(size=(12, 2))
    designs = known(lambda place: place.sum(), places)
    first, second = (_next(designs, FREE, places[0], _Region(0.1), step) for step in (3, 7))
    assert first is not None and second is not None and np.abs(first - second).max() > 1e-3


class Seen:
    """A surrogate that sees what it is given: aim and excess over a limit; places above 0.95 fail."""

    def __init__(self, values):
        self.values = np.asarray(values, float)

    def may_fail(self, places):
        return places[:, 0] > 0.95

    def at(self, places):
        return self.values[: len(places)]


@pytest.mark.parametrize(
    "values, margin, chosen",
    [
        ([[1.0, -0.5], [0.5, -0.5], [0.1, 0.2]], 0.0, 1),  # the least aim of those that keep the limit
        ([[1.0, -0.5], [0.5, -0.01], [0.1, 0.2]], 0.02, 0),  # with a margin
        ([[1.0, 0.5], [0.5, 0.3], [0.1, 0.4]], 0.0, 1),  # the least beyond where none does
        ([[1.0, -0.1], [0.5, -0.2], [0.1, -9.0]], 0.0, 2),
        ([[1.0, -0.9], [0.5, -0.1], [0.7, -0.3]], 0.0, 1),  # room to a limit is worth nothing
    ],
)
def test_the_best_keeps_limits_with_a_margin(values, margin, chosen):
    places = np.array([[0.1], [0.2], [0.3], [0.99]])
    assert _best_of(Seen(values), places, margin) == places[chosen]
    assert _best_of(Seen(values), places[3:], margin) is None


def test_every_choice_of_every_field_is_made_about_a_centre():
    space = space_of(
        SHIPPED, {SHAPE: ["linear", "parabolic"], RELIEF: [0, 8, 16, 24, 32], OTHER: ["linear", "parabolic"]}
    )
    centre = space.snapped(np.zeros(3))
    places = _about(space, centre, 0.1, choices=True)
    for column, made in enumerate((2, 5, 2)):
        _, times = np.unique(places[:, column], return_counts=True)
        assert len(times) == made and times.min() > 0.6 * len(places) / 6 / made


@pytest.mark.parametrize("choices", [False, True])
def test_designs_about_a_centre_lie_to_all_sides_and_half_of_them_choose_anew(choices):
    space = space_of(SHIPPED, {RELIEF: (0, 60), SHAPE: ["linear", "parabolic"]})
    centre = np.array([0.5, 0.25])
    places = _about(space, centre, 0.1, choices=choices)
    np.testing.assert_allclose(places[0], centre)
    assert places[:, 0].min() == pytest.approx(0.4, abs=2e-3)
    assert places[:, 0].max() == pytest.approx(0.6, abs=2e-3)
    # either choice is made anew as often, wherever the number is
    other = places[:, 1] == 0.75
    assert other.sum() == pytest.approx(len(places) / 4 if choices else 0, abs=8)
    assert (places[other, 0] > 0.5).sum() == pytest.approx(other.sum() / 2, abs=8)


# ---------------------------------------------------------------------- limits and aims


def test_values_are_the_aim_and_excesses_over_the_sizes_of_limits():
    limits = (Limit(SHARE, 0.5, True), Limit(EFFICIENCY, 0.8, False), Limit(WEAR, 0.0, True))
    designs = Tried(lambda place, _: ([3.0, 7.0], [0.6, 0.9, 2.0]), (Aim(WEAR), Aim(EFFICIENCY, False)), limits)
    (design,) = designs.solved([np.zeros(2)], COARSE)
    bounds = designs.bounds

    def values(goal: Goal) -> np.ndarray:
        return values_of(designs, goal, [design])[0]

    np.testing.assert_allclose(values(Goal(0, bounds)), [3.0, 0.2, -0.125, 2.0])
    wrong = Correction(PLANE, np.zeros((1, 2)), np.array([[0.5, -1.0, 0.1, -0.3, 0.0]]))
    np.testing.assert_allclose(values(Goal(0, bounds, correction=wrong)), [3.5, 0.4, 0.25, 2.0])
    # the other aim under a bound; greatest is least of the negative
    np.testing.assert_allclose(values(Goal(0, bounds, other=-8.0)), [3.0, 0.2, -0.125, 2.0, 0.125])
    np.testing.assert_allclose(values(Goal(1, bounds, other=2.0)), [-7.0, 0.2, -0.125, 2.0, 0.5])
    np.testing.assert_allclose(values(Goal(1, bounds, other=0.0))[-1], 3.0)


def test_a_design_that_could_not_be_solved_comes_last():
    designs = Tried(lambda place, _: ([np.nan if place[0] > 0.5 else 3.0], [0.6]), limits=(Limit(SHARE, 0.5, True),))
    tried = designs.solved([np.array([0.9, 0.0]), np.array([0.1, 0.0])], COARSE)
    np.testing.assert_allclose(values_of(designs, Goal(0, designs.bounds), tried), [[np.inf, np.inf], [3.0, 0.2]])
    assert best(designs, Goal(0, designs.bounds)) is tried[1]
    assert values_of(designs, Goal(0, designs.bounds), []).shape == (0, 2)


def test_the_best_design_keeps_its_limits_before_its_aim_counts():
    designs = Tried(lambda place, _: ([place[0]], [place[1]]), limits=(Limit(SHARE, 0.5, True),))
    designs.solved([np.array(place) for place in ([0.1, 0.9], [0.4, 0.4], [0.3, 0.5], [0.2, 0.6])], COARSE)
    designs.solved([np.array([0.0, 0.0])], DOUBLED)  # of another grid
    assert best(designs, Goal(0, designs.bounds)).point.tolist() == [0.3, 0.5]


def test_designs_next_to_one_that_failed_finely_come_last():
    """As long as none that was solved finely is as near; a failure without any other speaks for its place alone."""
    designs = Tried(lambda place, at: ([np.nan if at == DOUBLED and place[0] > 0.6 else 1.0 - place[0]], []))
    designs.solved([np.array([place, 0.5]) for place in (0.1, 0.3, 0.5, 0.7, 0.9)], COARSE)
    designs.solved([np.array([0.9, 0.5])], DOUBLED)
    assert best(designs, FREE).point[0] == 0.7
    designs.solved([np.array([0.1, 0.5])], DOUBLED)
    assert best(designs, FREE).point[0] == 0.5  # as near to either


# ---------------------------------------------------------------------- finer grids


def test_a_correction_goes_through_what_was_solved_finely_and_stays_within_it():
    places = np.array([[0.2, 0.2], [0.8, 0.4], [0.5, 0.9]])
    differences = np.array([[1.0, -2.0], [3.0, 0.0], [2.0, 4.0]])
    correction = Correction(PLANE, places, differences)
    np.testing.assert_allclose(correction.at(places), differences, atol=1e-12)
    far = correction.at(np.random.default_rng(0).uniform(size=(200, 2)))
    assert (far >= differences.min(axis=0) - 0.5).all() and (far <= differences.max(axis=0) + 0.5).all()
    # one design says the same everywhere
    np.testing.assert_allclose(Correction(PLANE, places[:1], differences[:1]).at(places), 3 * [[1.0, -2.0]])


def test_a_correction_tells_choices_without_an_order_apart():
    space = space_of(SHIPPED, {SHAPE: ["linear", "parabolic"], RELIEF: (0, 60)})
    places, differences = np.array([[0.25, 0.5], [0.75, 0.5], [0.25, 0.9]]), np.array([[1.0], [3.0], [2.0]])
    np.testing.assert_allclose(Correction(space, places, differences).at(places), differences, atol=1e-12)


def searched(monkeypatch: pytest.MonkeyPatch, designs: Tried, places: list[float], most: list[int]) -> list[Goal]:
    """Goals of searches that find the given places, one after the other."""
    goals, left = [], iter(places)

    def scripted(_, goal, count):
        goals.append(goal)
        most.append(count)
        return designs.solved([np.array([next(left), 0.0])], COARSE)[0]

    monkeypatch.setattr(fine, "search", scripted)
    return goals


def test_a_design_is_corrected_until_it_keeps_its_limits_on_the_fine_grid(monkeypatch):
    """Each search anew knows all errors of the coarse grid; bounds are drawn in by 0.2 % for each design beyond."""

    def values(place, resolution):
        wrong = (0.1 if resolution == DOUBLED else 0.0) * (1.0 + place[0])
        return [place[0] + wrong], [place[0] + wrong, 1.0 - place[0] - wrong]

    designs = Tried(values, limits=(Limit(SHARE, 0.5, True), Limit(EFFICIENCY, 0.4, False)))
    most: list[int] = []
    places = [0.9, 0.7, 0.35, 0.3495]  # the last is predicted to be no better by more than 0.2 %
    goals = searched(monkeypatch, designs, places, most)
    found = search_finely(designs, Goal(0, designs.bounds), 28)
    assert most == [28, 7, 7, 7]
    assert goals[0].correction is None
    for turn, goal in enumerate(goals[1:], 1):
        inwards = 0.002 * min(turn, 2)
        np.testing.assert_allclose(goal.bounds, [0.5 - 0.5 * inwards, 0.4 + 0.4 * inwards])
        known = np.array([[place, 0.0] for place in places[:turn]])
        wrong = (1.0 + known[:, :1]) * [0.1, 0.1, -0.1]
        np.testing.assert_allclose(goal.correction.at(known), wrong)
    assert found.kept
    assert found.doubled.point[0] == 0.35 and found.doubled.resolution == DOUBLED
    assert found.own.resolution == OWN and found.own.point[0] == 0.35


def test_a_design_that_comes_nearer_to_its_limits_is_solved_finely_though_within_no_margin(monkeypatch):
    """The second is 0.06 % nearer to the limit than the first, but not within the margin of 0.2 %."""
    coarse = {0.1: 0.501, 0.2: 0.5007, 0.3: 0.4985}
    designs = Tried(
        lambda place, resolution: ([1.0], [coarse[place[0]] + (0.001 if resolution == DOUBLED else 0.0)]),
        limits=(Limit(SHARE, 0.5, True),),
    )
    searched(monkeypatch, designs, [0.1, 0.2, 0.3, 0.3], [])
    found = search_finely(designs, Goal(0, designs.bounds), 20)
    assert found.kept and found.own.point[0] == 0.3


def test_a_design_that_keeps_its_limits_is_left_for_a_better_one(monkeypatch):
    """The coarse grid says too much: the best design it allows keeps a limit with room, and others are better."""
    designs = Tried(
        lambda place, resolution: ([1.0 - place[0]], [place[0] * (1.0 if resolution == COARSE else 0.8)]),
        limits=(Limit(SHARE, 0.5, True),),
    )
    searched(monkeypatch, designs, [0.5, 0.59, 0.61, 0.59], [])
    found = search_finely(designs, Goal(0, designs.bounds), 20)
    assert found.kept and found.own.point[0] == 0.61  # the fourth is known


@pytest.mark.parametrize(
    "error, far, seen",
    [(0.2, 0.89, True), (0.2, 0.91, False), (-0.05, 0.91, True), (-0.05, 0.93, False), (0.0, 0.9, False)],
)
def test_a_design_far_away_that_may_be_better_is_solved_finely(monkeypatch, error, far, seen):
    """Next to it the coarse grid errs by `error`, elsewhere not at all: there it may err by half as much less."""
    coarse, wrong = {0.1: 1.0, 0.5: 0.9, 0.9: far}, {0.1: 0.0, 0.5: error, 0.9: 0.0}
    designs = Tried(lambda at, resolution: ([coarse[at[0]] + (resolution == DOUBLED) * wrong[at[0]]], []))
    designs.solved([np.array([0.9, 0.0])], COARSE)
    searched(monkeypatch, designs, [0.1, 0.5, 0.5, 0.5], [])
    best = search_finely(designs, FREE, 20)
    fine = [float(one.point[0]) for one in designs.tried if one.resolution == DOUBLED]
    assert fine == ([0.1, 0.5, 0.9] if seen else [0.1, 0.5])
    assert best.doubled.aims[0] == min(coarse[at] + wrong[at] for at in fine)


@pytest.mark.parametrize("solved", [True, False])
def test_a_search_anew_that_finds_the_same_or_nothing_finely_solved_ends_it(monkeypatch, solved):
    designs = Tried(
        lambda place, resolution: ([1.0 if solved or resolution != DOUBLED else np.nan], [0.9]),
        limits=(Limit(SHARE, 0.5, True),),
    )
    most: list[int] = []
    searched(monkeypatch, designs, [0.9, 0.9], most)
    assert not search_finely(designs, Goal(0, designs.bounds), 20).kept
    assert len(most) == 1 + solved


def test_a_design_that_fails_finely_gives_way_to_the_next_best_one():
    """The best lies at 0.9; what lies beyond 0.6 cannot be solved on the fine grid, nor can what is next to it."""
    designs = Tried(
        lambda place, at: ([np.nan if at == DOUBLED and place[0] > 0.6 else 1.0 + (place[0] - 0.9) ** 2], [])
    )
    designs.solved([np.array([place, 0.5]) for place in (0.1, 0.3, 0.5, 0.7, 0.9)], COARSE)
    found = search_finely(designs, FREE, 8)
    assert found.kept and found.own.solved and found.doubled.solved
    assert 0.4 < found.doubled.point[0] <= 0.6
    assert sum(not one.solved for one in designs.tried) > 0


def test_nothing_that_can_be_solved_finely_is_told_after_all_turns():
    designs = Tried(lambda place, at: ([np.nan if at == DOUBLED else place[0]], []))
    designs.solved([np.array([place, 0.5]) for place in np.linspace(0.0, 1.0, 20)], COARSE)
    found = search_finely(designs, FREE, 4)
    assert not found.kept and not found.doubled.solved
    assert sum(one.resolution == DOUBLED for one in designs.tried) == 16


def test_a_life_without_end_is_the_best_and_goes_into_no_surrogate():
    lives = (Aim(replace(WEAR, text="life"), minimise=False),)
    designs = Tried(lambda place, _: ([np.inf if place[0] > 0.8 else 1e7 * (1.0 + place[0])], []), aims=lives)
    designs.solved([np.array([place, 0.5]) for place in (0.1, 0.3, 0.5, 0.7)], COARSE)
    found = search_finely(designs, FREE, 12)
    assert np.isinf(found.doubled.aims[0]) and found.own.point[0] > 0.8
    assert values_of(designs, FREE, [found.doubled])[0, 0] == -np.inf
    spread = finite_of(np.array([[-np.inf, 1.0], [2.0, np.inf], [4.0, 3.0]]))
    np.testing.assert_array_equal(spread, [[0.0, 1.0], [2.0, 5.0], [4.0, 3.0]])


def test_a_life_without_end_beside_others_that_are_alike_lies_beyond_by_their_size():
    found = finite_of(np.array([[5.0, 0.0, -2.0], [np.inf, -np.inf, np.inf], [5.0, 0.0, -2.0]]))
    np.testing.assert_array_equal(found, [[5.0, 0.0, -2.0], [10.0, -1.0, 0.0], [5.0, 0.0, -2.0]])


def test_no_more_than_sixteen_designs_are_solved_finely(monkeypatch):
    designs = Tried(lambda place, _: ([1.0], [3.0 - 2.0 * place[0]]), limits=(Limit(SHARE, 0.5, True),))
    searched(monkeypatch, designs, np.linspace(0.05, 0.95, 18).tolist(), [])
    found = search_finely(designs, Goal(0, designs.bounds), 20)
    fine = [one for one in designs.tried if one.resolution == DOUBLED]
    assert len(fine) == 16
    assert not found.kept
    assert found.doubled.limited[0] == min(one.limited[0] for one in fine)  # the least beyond

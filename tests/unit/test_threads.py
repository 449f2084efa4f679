"""Work on several threads: in order, without loss, and with the same bits for any number of them."""

import threading
import time
from functools import cache

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.threads import available_threads, in_loose_shares, in_shares, using_threads
from tests.same_result import different_variables
from tests.scenes import SMALL, TINY, scene_of

WORN = {"wear.until.control_depths_um": (2.0, 4.0)}
BOTH = {"wear.worn_bodies": ("pinion", "gear")}
PATCHES = {"numerics.fidelity": "patch"}


@cache
def on_one_thread(scene: sw.Scene) -> xr.DataTree:
    return sw.simulate(scene.replace({"numerics.threads": 1}))


def on_threads(scene: sw.Scene, count: int) -> list[str]:
    one, other = on_one_thread(scene), sw.simulate(scene.replace({"numerics.threads": count}))
    return [name for name in different_variables(one, other) if not name.startswith("attribute")]


@pytest.mark.parametrize(
    ("changes", "count"),
    [({}, 2), ({}, 3), (BOTH, 3), (PATCHES, 3)],
    ids=["gear-2", "gear-3", "both-3", "patches-3"],
)
def test_results_are_the_same_for_any_number(changes, count):
    assert on_threads(scene_of(SMALL, WORN, changes, wears=True), count) == []


def test_so_are_those_of_elastic_teeth_and_of_loaded_contact():
    scene = scene_of(TINY, WORN, {"numerics.tooth_compliance": "prism"}, wears=True)
    assert on_threads(scene, 2) == []
    one, other = (sw.loaded_contact(scene.replace({"numerics.threads": n})) for n in (1, 2))
    assert [name for name in different_variables(one, other) if not name.startswith("attribute")] == []


@pytest.mark.parametrize("count", [None, 1, 2, 5])
def test_shares_come_back_in_order(count):
    items = np.arange(3, 40)
    with using_threads(count):
        shares = in_shares(lambda share: share.tolist(), items)
        assert in_shares(lambda share: share.tolist(), items[:0]) == []
    assert [item for share in shares for item in share] == items.tolist()
    assert in_shares(lambda share: share.tolist(), items) == shares  # cut alike without threads


@pytest.mark.parametrize("threads", [1, 2])
def test_loose_shares_are_one_on_a_single_thread(threads):
    items = np.arange(37)
    with using_threads(threads):
        shares = in_loose_shares(lambda share: share.tolist(), items)
        assert in_loose_shares(lambda share: share.tolist(), items[:0]) == []
        assert len(shares) == (1 if threads == 1 else len(in_shares(lambda share: share, items)))
    assert [item for share in shares for item in share] == items.tolist()


def test_threads_are_used_and_a_share_keeps_to_its_own():
    meet = threading.Barrier(2, timeout=20.0)

    def work(share):
        meet.wait()  # two shares at once, or an error
        return {threading.get_ident() for _ in in_shares(lambda own: own, share)}

    with using_threads(2):
        threads = in_shares(work, np.arange(2))
    assert all(len(own) == 1 for own in threads)
    with pytest.raises(threading.BrokenBarrierError):
        meet.abort()
        in_shares(work, np.arange(2))


def test_a_share_of_the_thread_that_shares_out_stays_there_while_others_are_idle():
    meet, caller = threading.Barrier(2, timeout=20.0), threading.get_ident()

    def nested(own):
        time.sleep(2e-3)
        return threading.get_ident()

    def work(share):
        meet.wait()
        return set(in_shares(nested, np.arange(8))) if threading.get_ident() == caller else set()

    with using_threads(2):
        assert set().union(*in_shares(work, np.arange(2))) == {caller}


@pytest.mark.parametrize("count", [1, 4])
def test_the_first_error_is_told(count):
    def fail(share):
        raise ValueError(f"share {share[0]}")

    with using_threads(count), pytest.raises(ValueError, match="share 0"):
        in_shares(fail, np.arange(16))


def test_some_core_is_there():
    assert available_threads() >= 1

"""Floors that several runs share: what they get is the floor's motion, computed once."""

import threading

import numpy as np
import pytest

from ehamj.ground import GroundSample, Start
from ehamj.ground.floors import FloorGround
from ehamj.ground.shared import FLOORS, LASTING, ROOM, Floors, SharedMotion

START = Start(("a", "b"), np.array([[1.0, 0.0, 0.0], [-1.0, 0.5, 0.0]]), 1.0, 3)
TIMES = np.arange(50) * 1e-3


class Counted:
    """A floor that counts how often it is sampled."""

    at_rest, notes, usable_to, usable_from = False, ("a note",), 80.0, 0.5

    def __init__(self) -> None:
        self.calls = 0

    def sample(self, time: np.ndarray) -> GroundSample:
        self.calls += 1
        parts = np.sin(np.multiply.outer(np.arange(1.0, 4.0), time))
        return GroundSample(*np.repeat(parts, 6, axis=1).reshape(3, time.size, 2, 3))


def test_a_shared_floor_is_sampled_once_and_gives_what_it_gives_alone() -> None:
    counted = Counted()
    shared = SharedMotion(counted, 3)
    found = [shared.sample(TIMES.copy()) for _ in range(3)]
    assert counted.calls == 1
    for one in found:
        for part, alone in zip(one, Counted().sample(TIMES), strict=True):
            np.testing.assert_array_equal(part, alone)
    assert (shared.at_rest, shared.notes, shared.usable_to, shared.usable_from) == (False, ("a note",), 80.0, 0.5)


def test_nobody_changes_what_others_get() -> None:
    shared = SharedMotion(Counted(), 2)
    with pytest.raises(ValueError, match="read-only"):
        shared.sample(TIMES).velocity[0] = 1.0


def test_what_all_have_got_is_forgotten() -> None:
    shared = SharedMotion(Counted(), 2)
    for begin in range(5):
        for _ in range(2):
            shared.sample(TIMES + begin)
    assert not shared._kept


def test_what_some_have_not_got_is_kept_within_bounds_and_computed_anew_else() -> None:
    counted = Counted()
    shared = SharedMotion(counted, 2)
    stretch = np.arange(20_000) * 1e-4
    size = 10 * stretch.nbytes * 2  # more than one sample has
    count = int(2 * ROOM / size) + 1
    for number in range(count):
        shared.sample(stretch + number)
    assert sum(kept.size for kept in shared._kept.values()) <= ROOM
    shared.sample(stretch)  # long forgotten
    assert counted.calls == count + 1


def test_threads_that_ask_at_once_let_one_compute() -> None:
    counted, begin = Counted(), threading.Barrier(4)
    shared = SharedMotion(counted, 4)

    def ask() -> None:
        begin.wait()
        for number in range(20):
            shared.sample(TIMES + number)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert counted.calls == 20


def test_floors_are_one_where_ground_plan_and_seed_are() -> None:
    ground = FloorGround(kind="floor", floor="workshop")
    floors = Floors(2)
    first = floors.motion(ground, START)
    assert floors.motion(ground.model_copy(), START) is first
    other = Start(START.mounts, START.positions, START.duration, 4)
    assert floors.motion(ground, other) is not first


def test_floors_without_an_end_are_kept_within_bounds() -> None:
    ground = FloorGround(kind="floor", floor="workshop")
    floors = Floors(None)
    starts = [Start(START.mounts, START.positions, START.duration, seed) for seed in range(FLOORS + 1)]
    found = [floors.motion(ground, one) for one in starts]
    assert floors.motion(ground, starts[-1]) is found[-1]
    assert floors.motion(ground, starts[0]) is not found[0]  # the oldest is gone
    counted = Counted()
    shared = SharedMotion(counted, None)
    for number in (0, 1) * 20:
        shared.sample(TIMES + number)
    assert counted.calls == 2
    stretch = np.arange(20_000) * 1e-4
    for number in range(int(LASTING / (18 * stretch.nbytes)) + 2):
        shared.sample(stretch + number)
    assert sum(kept.size for kept in shared._kept.values()) <= LASTING

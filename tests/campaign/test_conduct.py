"""A study asks its plan, computes what is not stored, goes on where it was, and is refused where it is another."""

import threading
import tracemalloc
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from oracles.fake_studies import NAMES, Drawn, Plain, closed, done, machine, results, search

from ehamj.campaign.conduct import conduct
from ehamj.campaign.plans.plan import Batches, Goals, Told
from ehamj.campaign.stages import Again, Around
from ehamj.campaign.standing import Standing
from ehamj.campaign.store import STORE_FILE, Store, reading
from ehamj.campaign.tables import frame
from ehamj.errors import InputError
from ehamj.merits.merit import Machine
from ehamj.scenario.load import load_scenario

GOALS = Goals([("fake.root", -1.0), ("fake.sum", 1.0)], [("fake.product", 1.0, 9.0), ("fake.sum", None, 50.0)])


class Stop(Exception):
    """Ends a study from within."""


def stopping(after: int) -> Any:
    """Progress that ends a study once so many designs are done."""

    def progress(standing: Standing) -> None:
        if standing.done >= after:
            raise Stop

    return progress


def test_a_search_is_told_what_its_designs_came_out_with(tmp_path: Path) -> None:
    heard: list[Told] = []

    class Listening(Drawn):
        def batches(self, space: Any, goals: Goals) -> Batches:
            for points in super().batches(space, goals):
                heard.append((yield points))

    done(tmp_path, search(Listening(number=24, batch=20), goals=GOALS))
    assert [len(told.objectives) for told in heard] == [20, 4]
    table = frame(tmp_path)
    own = closed(7.0, table["machine.cg.2"][7])
    np.testing.assert_array_equal(heard[0].objectives[7], [-own["root"], own["sum"]])
    beyond = max(1.0 - own["product"], own["product"] - 9.0)
    np.testing.assert_array_equal(heard[0].violations[7], [beyond, own["sum"] - 50.0])
    assert np.isnan(heard[0].objectives[5]).all()
    assert np.isnan(heard[0].violations[5]).all()


@pytest.mark.parametrize("after", [8, 24, 40])
def test_a_resumed_study_computes_only_what_is_missing(tmp_path: Path, after: int) -> None:
    stage = search(Drawn(number=60, batch=40), goals=GOALS)
    done(tmp_path / "whole", stage)
    with pytest.raises(Stop):
        done(tmp_path / "part", stage, progress=stopping(after))
    seen: list[Standing] = []
    done(tmp_path / "part", stage, resume=True, progress=seen.append)
    assert seen[-1].found >= after
    assert seen[-1].done == 60
    pd.testing.assert_frame_equal(results(tmp_path / "part"), results(tmp_path / "whole"), check_exact=True)


def test_what_is_done_stays_done(tmp_path: Path) -> None:
    done(tmp_path)
    before = (tmp_path / STORE_FILE).read_bytes()
    with pytest.raises(InputError, match="holds 64 designs already; resume it, or name another folder"):
        done(tmp_path)
    again = done(tmp_path, resume=True)
    assert (again.done, again.failed, again.complete, again.stages) == (64, 3, True, {"search": (0, 64)})
    with reading(tmp_path) as store:
        assert store.said("stages") == {"search": [0, 64]}
    assert len(before) == (tmp_path / STORE_FILE).stat().st_size


HEAVY = Machine(load_scenario("recorded", ["machine.mass=4321"]))
OTHERS = [
    ({"stage": search(Drawn(seed=1))}, "stages.search.plan.seed was 0 and is 1"),
    ({"stage": search(machine=HEAVY)}, "stages.search.scenario.machine.mass was .* and is 4321"),
    ({"stage": search(machine=replace(machine(), law="derived"))}, "stages.search.law was 'held' and is 'derived'"),
    ({"stage": search(names=NAMES[:2])}, "stages.search.merits was"),
    ({"functions": {"cost": max}}, "functions.own.cost was absent"),
]


@pytest.mark.parametrize(("other", "said"), OTHERS)
def test_another_study_is_not_resumed(tmp_path: Path, other: dict[str, Any], said: str) -> None:
    done(tmp_path, search(Drawn(number=8)))
    stage = other.get("stage", search(Drawn(number=8)))
    plan = stage.plan if stage.plan.seed else Drawn(number=8)
    with pytest.raises(InputError, match=f"cannot be resumed.*{said}.*resume it as it was, or begin a new one"):
        done(tmp_path, replace(stage, plan=plan), resume=True, functions=other.get("functions"))
    assert done(tmp_path, search(Drawn(number=8)), resume=True).complete


def test_other_versions_do_not_resume(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done(tmp_path, search(Drawn(number=8)))
    monkeypatch.setattr("ehamj.campaign.conduct.versions", lambda: {"numpy": "1.0"})
    with pytest.raises(InputError, match=r"versions.numpy was '.*' and is '1\.0'.*; resume it "):
        done(tmp_path, search(Drawn(number=8)), resume=True)


def test_nothing_to_resume_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no designs\.sqlite to resume"):
        done(tmp_path / "nowhere", resume=True)
    assert not (tmp_path / "nowhere").exists()


def test_an_unknown_merit_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such merit"):
        done(tmp_path / "study", search(names=("fake.som",)))
    assert not (tmp_path / "study").exists()


@dataclass(frozen=True)
class Near:
    """Masses a kilogram around one."""

    mass: float
    keys = ("machine.mass",)
    units = ("kg",)

    def values(self, points: Any) -> list[dict[str, float]]:
        return [{"machine.mass": self.mass + float(point)} for point in points[:, 1]]


def heaviest(store: Store) -> list[Any]:
    rows = [row for row in store.rows() if row.stage == "search" and not row.failed]
    return [(row.number, {**row.values}) for row in rows[-2:]]


def test_stages_follow_each_other_in_one_store(tmp_path: Path) -> None:
    first = search(Drawn(number=12))
    keys = first.values()
    tolerance = Around(
        "tolerance",
        machine(),
        NAMES,
        heaviest,
        keys,
        2,
        Drawn(number=10),
        lambda values: Near(values.get("machine.mass", 0.0)),
    )
    confirm = Again("confirm", HEAVY, NAMES[:1], heaviest, keys, 3)
    stages = [first, tolerance, confirm]
    seen: list[Standing] = []
    ended = conduct(tmp_path / "whole", stages, scheduler="threads:1", progress=seen.append)
    assert ended.stages == {"search": (0, 12), "tolerance": (12, 32), "confirm": (32, 34)}
    assert seen[-1].total == 12 + 20 + 3
    table = frame(tmp_path / "whole")
    assert table.loc[12:, "parent"].tolist() == [10] * 10 + [11] * 10 + [10, 11]
    assert table["machine.mass"][12:22].between(10.0, 11.0).all()
    assert (table["machine.cg.2"][12:22] == table["machine.cg.2"][10]).all()
    np.testing.assert_array_equal(
        table["machine.mass"][12:22].to_numpy() + 1.0, table["machine.mass"][22:32].to_numpy()
    )
    assert table["fake.product"][32:].isna().all()
    with pytest.raises(Stop):
        conduct(tmp_path / "part", stages, scheduler="threads:1", progress=stopping(20))
    conduct(tmp_path / "part", stages, scheduler="threads:2", resume=True)
    pd.testing.assert_frame_equal(results(tmp_path / "part"), results(tmp_path / "whole"), check_exact=True)


def test_a_study_whose_time_is_used_up_says_so_and_goes_on_later(tmp_path: Path) -> None:
    ended = done(tmp_path, hours=0.0)
    assert not ended.complete
    assert ended.done == 0
    assert done(tmp_path, resume=True, hours=1.0).complete


def test_progress_tells_rate_time_left_and_the_best(tmp_path: Path) -> None:
    seen: list[Standing] = []
    done(tmp_path, search(space=Plain(pause=0.01), goals=GOALS), progress=seen.append)
    table = frame(tmp_path)
    good = table[table["fake.product"].between(1.0, 9.0) & (table["fake.sum"] <= 50.0)]
    last = seen[-1]
    assert last.best["fake.root"] == (good["fake.root"].idxmax(), good["fake.root"].max())
    assert last.best["fake.sum"] == (good["fake.sum"].idxmin(), good["fake.sum"].min())
    assert [one.done for one in seen] == [*range(0, 65, 8)]
    assert (last.failed, last.left) == (3, 0.0)
    middle = next(one for one in seen if one.done == 32)
    assert middle.left == pytest.approx(32 / middle.rate)
    assert 10.0 < middle.rate < 800.0
    assert middle.words.startswith("search: 32 of 64 designs, 3 failed, ")
    assert Standing("named", 1, 3).words == "named: 1 of 3 designs, the scenario's own among them"


@pytest.mark.parametrize("scheduler", ["threads:2", "processes:1"])
def test_an_interruption_keeps_what_is_done_and_is_told_first(tmp_path: Path, scheduler: str) -> None:
    seen: list[Standing] = []

    def progress(standing: Standing) -> None:
        seen.append(standing)
        if standing.done == 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        done(tmp_path, progress=progress, scheduler=scheduler)
    assert seen[-1].words == "interrupted: 16 of 64 designs are stored; resumed, it goes on from there"
    assert done(tmp_path, resume=True).complete


def test_a_full_disk_ends_a_study_that_goes_on_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = Store.append

    def full(store: Store, rows: Any) -> None:
        store.execute("PRAGMA max_page_count = 12")
        whole(store, [replace(row, values={**row.values, "deadly": "x" * 4000}) for row in rows])

    with monkeypatch.context() as patched:
        patched.setattr(Store, "append", full)
        with pytest.raises(OSError, match="no space is left; finished designs are kept"):
            done(tmp_path, scheduler="threads:2")
    assert threading.active_count() < 20
    assert done(tmp_path, resume=True).complete


def most(folder: Path, number: int) -> int:
    """Most memory that a study of so many designs holds at once [B]: what Python and NumPy take, which no allocator
    rounds."""
    stage = search(Drawn(number=number, batch=500), names=("many.sum", "many.root"), goals=Goals([("many.sum", 1.0)]))
    tracemalloc.start()
    try:
        done(folder, stage)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_number_of_designs(tmp_path: Path) -> None:
    most(tmp_path / "warm", 100)
    few, many = most(tmp_path / "few", 2_500), most(tmp_path / "many", 10_000)
    assert many - few < 7_500 * 100  # a design takes 660 where its row stays

"""A cluster of Dask's computes the same designs, and may lose a worker."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import distributed
import numpy as np
import pandas as pd
import pytest
from oracles.fake_studies import done, results, search

from ehamj.campaign.cluster import Dask
from ehamj.campaign.conduct import conduct
from ehamj.campaign.file import StudyFile
from ehamj.campaign.staged import stages_of
from ehamj.campaign.tables import frame
from ehamj.errors import InputError, SimulationFailed

POPULATION, GENERATIONS = 12, 2
SEARCH: dict[str, Any] = {
    "title": "Anywhere",
    "question": "Does it matter where?",
    "scenario": "vc-c-floor",
    "set": {
        "engine": "small-motion",
        "plates": "tied",
        "duration": 0.06,
        "compare": [],
        "control": {"kind": "combined"},
    },
    "vary": {
        "actuators.isolator.piston_area": {"low": 0.02, "high": 0.06},
        "machine.mass": {"low": 3000.0, "high": 5000.0},
    },
    "plan": {"kind": "optimise", "population": POPULATION, "generations": GENERATIONS},
    "objectives": {"run.rms.cg_velocity.z": "lowest", "run.oil.mean_power_w": "lowest"},
}
"""Twelve designs are a block of eight lanes and one of four."""


def searched(folder: Path, scheduler: Any) -> pd.DataFrame:
    """All designs of the search."""
    conduct(folder, stages_of(StudyFile(**SEARCH)), {"title": "Anywhere"}, scheduler=scheduler)
    return frame(folder).drop(columns="seconds")


@pytest.fixture(scope="module")
def alone_over_runs(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """On one thread."""
    found = searched(tmp_path_factory.mktemp("alone"), "threads:1")
    own = found[found["stage"] == "search"]
    assert len(own) == POPULATION * GENERATIONS
    assert not (own["status"] == "failed").any()
    assert np.isfinite(own["run.rms.cg_velocity.z"]).all()
    assert own["run.rms.cg_velocity.z"].nunique() == len(own)  # another order, lane or neighbour could show
    return found


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two workers, each a process, on the loopback."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0"
    ) as found:
        yield found


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """On one thread."""
    folder = tmp_path_factory.mktemp("alone")
    done(folder)
    return results(folder)


def test_results_are_equal_to_the_bit_by_address_cluster_and_client(
    tmp_path: Path, alone: pd.DataFrame, cluster: Any
) -> None:
    with distributed.Client(cluster, set_as_default=False) as client:
        for name, given in {"address": cluster.scheduler_address, "cluster": cluster, "client": client}.items():
            done(tmp_path / name, scheduler=given)
            pd.testing.assert_frame_equal(results(tmp_path / name), alone, check_exact=True)
        assert client.status == "running"  # it is not ours to close


def test_own_functions_go_along(tmp_path: Path, cluster: Any) -> None:
    stage = search(names=("fake.sum", "own.count"))
    ended = done(tmp_path, stage, scheduler=cluster, functions={"count": lambda scenario: len(scenario.plant.mounts)})
    assert ended.failed == ended.done == 64  # no machine has these masses
    assert results(tmp_path)["reason"][0].startswith("own: ")


@pytest.mark.parametrize("where", ["threads:2", "processes:2", "cluster"])
def test_a_search_over_runs_is_the_same_to_the_bit_generation_by_generation(
    tmp_path: Path, alone_over_runs: pd.DataFrame, cluster: Any, where: str
) -> None:
    found = searched(tmp_path, cluster if where == "cluster" else where)
    pd.testing.assert_frame_equal(found, alone_over_runs, check_exact=True)


def test_a_worker_that_is_lost_loses_no_design(tmp_path: Path, alone: pd.DataFrame, cluster: Any) -> None:
    pids = [worker.pid for worker in cluster.workers.values()]

    def progress(standing: Any) -> None:
        if standing.done == 8:
            os.kill(pids[0], signal.SIGKILL)

    done(tmp_path, scheduler=cluster, progress=progress)
    pd.testing.assert_frame_equal(results(tmp_path), alone, check_exact=True)


def test_a_scheduler_that_does_not_answer_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehamj.campaign.cluster.PATIENCE", 0.2)
    for address in ("tcp://127.0.0.1:9", "nothing://127.0.0.1:9"):
        with pytest.raises(InputError, match=f"scheduler '{address}': no Dask scheduler answers there"):
            done(tmp_path / "study", scheduler=address)
    assert not (tmp_path / "study").exists()


def test_without_dask_it_is_said_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'ehamj\[dask\]'"):
        done(tmp_path / "study", scheduler=Dask("tcp://127.0.0.1:9"))


def test_a_scheduler_that_goes_ends_the_study_with_what_is_done(tmp_path: Path, alone: pd.DataFrame) -> None:
    gone = distributed.LocalCluster(
        n_workers=1, processes=False, protocol="tcp://", host="127.0.0.1", dashboard_address=":0"
    )

    def progress(standing: Any) -> None:
        if standing.done == 8:
            gone.close()

    with pytest.raises((SimulationFailed, InputError)) as said:
        done(tmp_path, scheduler=gone, progress=progress)
    assert "Dask scheduler" in str(said.value)
    assert done(tmp_path, resume=True).complete
    pd.testing.assert_frame_equal(results(tmp_path), alone, check_exact=True)

"""A search over nonlinear runs comes out the same to the bit, generation by generation, wherever its runs are."""

from pathlib import Path
from typing import Any

import distributed
import numpy as np
import pandas as pd
import pytest

from ehamj.campaign.conduct import conduct
from ehamj.campaign.file import StudyFile
from ehamj.campaign.staged import stages_of
from ehamj.campaign.tables import frame

POPULATION, GENERATIONS = 12, 2
FILE: dict[str, Any] = {
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
    conduct(folder, stages_of(StudyFile(**FILE)), {"title": "Anywhere"}, scheduler=scheduler)
    return frame(folder).drop(columns="seconds")


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """On one thread."""
    found = searched(tmp_path_factory.mktemp("alone"), "threads:1")
    own = found[found["stage"] == "search"]
    assert len(own) == POPULATION * GENERATIONS
    assert not (own["status"] == "failed").any()
    assert np.isfinite(own["run.rms.cg_velocity.z"]).all()
    assert own["run.rms.cg_velocity.z"].nunique() == len(own)  # another order, lane or neighbour could show
    return found


@pytest.mark.parametrize("scheduler", ["threads:2", "processes:2"])
def test_threads_and_processes_find_the_same(tmp_path: Path, alone: pd.DataFrame, scheduler: str) -> None:
    pd.testing.assert_frame_equal(searched(tmp_path, scheduler), alone, check_exact=True)


def test_a_cluster_of_two_workers_finds_the_same(tmp_path: Path, alone: pd.DataFrame) -> None:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0"
    ) as cluster:
        pd.testing.assert_frame_equal(searched(tmp_path, cluster.scheduler_address), alone, check_exact=True)

"""Variants of a run that stand on one floor get what each gets alone."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import xarray as xr

from ehamj import load_scenario
from ehamj.ground.motion import Combined, GroundSample
from ehamj.ground.shared import Floors
from ehamj.run.simulate import simulate


def test_variants_on_threads_share_one_floor_and_give_what_each_gives_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load_scenario("workshop", ["duration=0.5", "output.replay=false"])
    variants = [scenario, scenario.variant("passive")]
    alone = [simulate(one) for one in variants]
    asked: list[tuple[int, bytes]] = []
    sample = Combined.sample

    def counted(self: Combined, time: np.ndarray) -> GroundSample:
        asked.append((id(self), time.tobytes()))
        return sample(self, time)

    monkeypatch.setattr(Combined, "sample", counted)
    floors = Floors(len(variants))
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda one: simulate(one, floors=floors), variants))
    assert len(asked) == len(set(asked))
    assert len({motion for motion, _ in asked}) == 2  # the sum, and the floor in it: built once
    for one, other in zip(alone, together, strict=True):
        xr.testing.assert_identical(one.dataset, other.dataset)
        assert one.summary.changed(timing=other.summary.timing).to_dict() == other.summary.to_dict()

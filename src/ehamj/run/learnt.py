"""From a run's channels to what its law has learnt."""

import numpy as np
import xarray as xr

from ehamj.control.converter import Converter
from ehamj.control.learners import Learner, Learnt
from ehamj.control.valves import Known
from ehamj.judge.learnt import Belief, Beliefs


def learnt(dataset: xr.Dataset, converter: Converter) -> Beliefs:
    """What each mount has learnt at the end of a run; empty where nothing is learnt."""
    if not converter.learners or not dataset.sizes["time"]:
        return {}
    last = np.array([dataset[f"learnt_{name}"].values[-1] for name in Learnt._fields], float).T
    known = zip(converter.mounts, converter.learners, converter.valves, last, strict=True)
    return {mount: _told(learner, valve.numbers, Learnt(*row.tolist())) for mount, learner, valve, row in known}


def _told(of: Learner, valve: Known, found: Learnt) -> dict[str, Belief]:
    """What one mount has learnt, of what it may learn."""
    stiffness, overlap = of.area / of.oil, min(valve.supply_1, valve.tank_1, valve.supply_2, valve.tank_2)
    told = {
        "flow_gain": (of.flow, of.flow * found.flow_gain),
        "oil_stiffness": (stiffness, stiffness / found.compliance),
        "overlap": (overlap, overlap + found.overlap),
        "play": (valve.play, valve.play + found.play),
        "null_offset": (valve.offset, valve.offset + found.null_offset),
    }
    free = (high > low for low, high in zip(of.ranges[::2], of.ranges[1::2], strict=True))
    return {
        name: Belief(stated=stated, learnt=now)
        for (name, (stated, now)), may in zip(told.items(), free, strict=True)
        if may
    }

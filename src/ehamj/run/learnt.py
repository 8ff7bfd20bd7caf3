"""From a run's channels to what its law has learnt."""

import numpy as np
import xarray as xr

from ehamj.control import AnyController
from ehamj.control.converter import Converter
from ehamj.control.learners import Learner, Learnt
from ehamj.control.valves import Known
from ehamj.judge.learnt import Belief, Beliefs, nothing
from ehamj.judge.lines import FoundLine


def learnt(dataset: xr.Dataset, converter: Converter) -> Beliefs:
    """What each mount has learnt at the end of a run; empty where nothing is learnt."""
    if not converter.learners or not dataset.sizes["time"]:
        return {}
    last = np.array([dataset[f"learnt_{name}"][-1].values for name in Learnt._fields], float).T
    known = zip(converter.mounts, converter.learners, converter.valves, last, strict=True)
    return {mount: _told(learner, valve.numbers, Learnt(*row.tolist())) for mount, learner, valve, row in known}


def unlearnt(found: Beliefs, converter: Converter) -> list[str]:
    """What must be said of the mounts of which nothing was learnt, though something was to be."""
    leasts = {mount: of.least for mount, of in zip(converter.mounts, converter.learners, strict=False)}
    by_least: dict[float, list[str]] = {}
    for mount, told in found.items():
        if told and nothing(told):
            by_least.setdefault(leasts[mount], []).append(mount)
    return [
        f"nothing was learnt of {', '.join(mounts)}: flow that shows it, in control.learning.band, stayed below "
        f"{least:g} mA of opening RMS (control.learning.least, and control.linearisation.band where edges are "
        "made good), or came only while a command was limited or faded, or soon after"
        for least, mounts in by_least.items()
    ]


def found_lines(dataset: xr.Dataset, law: AnyController | None) -> list[FoundLine]:
    """Where the lines that a law follows were at the end of a run; empty where it follows none."""
    if law is None or not law.lines or not dataset.sizes["time"]:
        return []
    last = dataset["line_frequency"][-1].values.tolist()
    return [
        FoundLine(stated=line.frequency, low=line.low, high=line.high, found=found)
        for line, found in zip(law.lines, last, strict=True)
    ]


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

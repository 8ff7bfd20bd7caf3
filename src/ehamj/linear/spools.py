"""Margins of the loops about the spools (`ehamj.control.spools`), of a machine's valves as they are."""

import numpy as np

from ehamj.control import LinearController
from ehamj.control.blocks import response
from ehamj.control.sensors import Sensors
from ehamj.control.spools import opened, runs_away
from ehamj.linear.margins import Margins, margins
from ehamj.plant.plant import Plant


def spool_margins(plant: Plant, law: LinearController | None, sensors: Sensors) -> dict[str, Margins | None]:
    """Margins of each mount whose spool is fed back, its valve the machine's own; None where the loop is unstable.

    Outside the play of its valve: within it the loop is open.
    """
    spools = () if law is None else law.converter.spools
    found: dict[str, Margins | None] = {}
    for mount, actuator, own in zip(plant.mounts, plant.actuators, spools, strict=False):
        if not own.crossing:
            continue
        sensor = sensors.spool
        loop = opened(own, sensor, actuator)
        hertz = np.geomspace(1.0, 0.499 / own.period, 400)
        gain = response(np.exp(2j * np.pi * hertz * own.period), *loop)[:, 0, 0]
        found[mount] = None if runs_away(loop) >= 1.0 else margins(hertz, gain)
    return found

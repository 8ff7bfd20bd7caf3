"""A record compared in frequency: what is left between it and the linear model is its noise, and nothing else."""

from pathlib import Path

import numpy as np

import ehamj
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.excitation import valve_test
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

TRUE = {"actuators.isolator.flow_gain": 2.1e-6, "machine.mass": 3600.0}
OUTPUTS = ("stroke front-left", "foot_acceleration rear-right z")
SECONDS, RATE = 4.0, 500.0


def test_segments_that_are_short_beside_how_long_it_rings_leave_no_error(tmp_path: Path) -> None:
    """Segments of 0.5 s of a machine whose resonances ring longer: leakage would be many times the noise of 1 %."""
    machine = parse_scenario(
        {
            "plates": "tied",
            "compare": [],
            "engine": "small-motion",
            "timestep": 1e-4,
            "points": {},
            "machine": {"inertia": [2000.0, 3000.0, 4000.0]},
        }
    )
    machine.save(tmp_path / "rig.toml")
    run = valve_test(
        machine.varied(TRUE), tmp_path / "played.csv", rate=20000.0, duration=SECONDS, band=(3.0, 60.0), volts=0.02
    )
    given = [Tap(channel=f"valve_command {mount}", bits=None) for mount in MOUNTS]
    seen = [Tap(channel=name, noise=0.01) for name in OUTPUTS]
    logged(simulate(run.model_copy(update={"record_rate": RATE})), [*given, *seen], seed=2).save(tmp_path / "log.csv")
    measurement = {tap.channel: {"channel": tap.channel} for tap in (*given, *seen)}
    found = ehamj.identify(
        {
            "scenario": str(tmp_path / "rig.toml"),
            "parameters": {key: {} for key in TRUE},
            "fit": {"starts": 1},
            "test": [{"name": "sweep", "kind": "record", "file": str(tmp_path / "log.csv"), "compare": "frequency",
                      "band": [3.0, 60.0], "segment": 0.5, "measurement": measurement}],
        }
    )  # fmt: skip
    assert not any("own noise" in note for note in found.notes)
    for key, true in TRUE.items():
        one = found.values[key]
        assert one.value is not None
        assert one.deviation is not None
        assert abs(one.value - true) < 3.5 * one.deviation < 0.01 * true
    left = [np.abs(one.measured - one.predicted) ** 2 / one.deviation**2 for one in found.tests[0].channels]
    assert 0.2 < np.mean(np.concatenate(left)) < 1.5

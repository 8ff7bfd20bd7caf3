"""What a moving floor makes of a machine, as a logger wrote it, is predicted from the floor that it wrote beside it."""

from pathlib import Path

import numpy as np

from ehamj.identification.file import load_identify
from ehamj.identification.identify import prepared
from ehamj.linear.machine import grounds
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import observed
from ehamj.scenario.load import load_scenario


def test_a_recorded_floor_moves_the_machine_as_the_floor_did(tmp_path: Path) -> None:
    """Records fade at their ends and lose what drifts; what is compared is neither."""
    seen = ("stroke front-left", "chamber_pressure rear-right 1", "foot_velocity front-left z")
    still = {"control": {"kind": "passive"}, "compare": []}
    run = observed(
        load_scenario("vc-c-floor", ["duration=2", "control={kind='passive'}", "compare=[]", "engine=small-motion",
                                     "record_rate=1000"])
    )  # fmt: skip
    driving = [f"ground_velocity {place}" for place in grounds(run.scenario.plant.mounts)]
    logged(run, [Tap(channel=name, bits=None) for name in (*driving, *seen)]).save(tmp_path / "floor.csv")
    test = {"name": "floor", "kind": "record", "file": str(tmp_path / "floor.csv"), "settle": 0.5, "set": still,
            "measurement": {name: {"channel": name} for name in (*driving, *seen)}}  # fmt: skip
    table = {"scenario": "vc-c-floor", "parameters": {"machine.mass": {}}, "test": [test]}
    parameters, (made,) = prepared(load_identify(table), {}, 1)
    (found,) = made.compared([{one.name: one.start for one in parameters}])
    assert not isinstance(found, Exception)
    for channel in found:
        assert np.std(channel.error) < 0.02 * np.std(channel.measured), channel.name

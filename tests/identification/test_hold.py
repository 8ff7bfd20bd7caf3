"""Commands that a converter holds between samples: the model is driven as the rig was."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from draws.trial import ASIDE, RATE, SHAKER, believed, file_of, taps

from ehamj.errors import InputError
from ehamj.identification.file import load_identify
from ehamj.identification.identify import prepared
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.excitation import valve_test
from ehamj.rig.logger import Tap, logged
from ehamj.run.many import observe_many
from ehamj.scenario.load import changed

SEEN = {"chamber_pressure front-left 1": "P01", "stroke front-left": "S0"}


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A rig whose commands are held."""
    folder: Path = tmp_path_factory.mktemp("held")
    played = valve_test(believed(), folder / "played.csv", rate=RATE, duration=0.25, shaker=SHAKER)
    signals = [{**signal, "hold": "held"} for signal in played.table["control"]["signals"]]
    rig = changed(played, {"control": {"kind": "open-loop", "signals": signals}, "timestep": 1e-4})
    (run,) = observe_many([rig], lambda run: run)
    given = [Tap(channel=f"valve_command {mount}", name=f"U{k}", bits=None) for k, mount in enumerate(MOUNTS)]
    given.append(Tap(channel="force 0", name="F", bits=None))
    logged(run, [*given, *taps(SEEN)]).save(folder / "valves.csv")
    file = file_of("few", folder)
    measurement = file["test"][0]["measurement"]
    file["test"][0]["measurement"] = {
        key: one for key, one in measurement.items() if key[0] in "UF" or key in SEEN.values()
    }
    return file


def left(asked: dict[str, Any], hold: dict[str, str]) -> float:
    """RMS of what the machine that was measured leaves of the pressure, over the pressure's."""
    test = asked["test"][0]
    given = {key: {**one, **hold} if key[0] == "U" else one for key, one in test["measurement"].items()}
    file = load_identify({**asked, "set": {"timestep": 1e-4}, "test": [{**test, "measurement": given}]}, ())
    parameters, tests = prepared(file, {}, None)
    problem = Problem(tests, parameters)
    (at,) = problem.compared([np.array([one.scaled(ASIDE) if one.level else 0.0 for one in problem.unknowns])])
    assert not isinstance(at, Failed)
    return float(np.sqrt(np.mean(at[0].error ** 2)) / np.std(at[0].measured))


def test_held_commands_drive_as_they_did(asked: dict[str, Any]) -> None:
    assert left(asked, {"hold": "held"}) == pytest.approx(0.01, rel=0.4)  # its noise, and steps of its converter
    assert left(asked, {}) > 0.04


def test_what_does_not_drive_is_not_held(asked: dict[str, Any]) -> None:
    test = asked["test"][0]
    given = {**test["measurement"], "P01": {"channel": "chamber_pressure front-left 1", "hold": "held"}}
    file = load_identify({**asked, "test": [{**test, "measurement": given}]}, ())
    with pytest.raises(InputError, match=r"P01\.hold = 'held'"):
        prepared(file, {}, None)

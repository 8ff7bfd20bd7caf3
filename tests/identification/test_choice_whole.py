"""A file's [choice], from simulated measurements of a machine whose valves have an overlap and no hysteresis."""

from pathlib import Path

import pytest

import ehamj
from ehamj.cli.identify import print_found
from ehamj.identification.file import load_identify
from ehamj.measured.reading import read_measured
from ehamj.rig.excitation import valve_test
from ehamj.rig.logger import Tap, logged
from ehamj.run.many import observe_many
from ehamj.scenario.load import parse_scenario

ISOLATOR = "actuators.isolator"


def test_an_overlap_that_is_there_is_found_and_a_hysteresis_that_is_not_is_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    believed = parse_scenario({"points": {}, "timestep": 1e-4})
    true = believed.varied({f"{ISOLATOR}.flow_gain": 2.2e-6, f"{ISOLATOR}.overlap": [0.3] * 4})
    mounts, record = believed.plant.mounts, tmp_path / "valves.csv"
    run = valve_test(true, tmp_path / "played.csv", duration=0.4)
    given = [Tap(channel=f"valve_command {mount}", bits=None) for mount in mounts]
    seen = [Tap(channel=f"chamber_pressure {mount} 1", unit="bar", noise=0.01) for mount in mounts]
    (made,) = observe_many([run], lambda run: run)
    logged(made, [*given, *seen], seed=1).save(record)
    believed.save(tmp_path / "believed.toml")
    test = {
        "kind": "record", "name": "valves", "file": str(record), "settle": 0.0, "rate": 2000.0,
        "measurement": {tap.channel: {"channel": tap.channel} for tap in [*given, *seen]},
    }  # fmt: skip
    file = load_identify(
        {
            "scenario": str(tmp_path / "believed.toml"), "test": [test], "fit": {"starts": 1},
            "parameters": {f"{ISOLATOR}.flow_gain": {}, f"{ISOLATOR}.bulk_modulus": {}},
            "choice": {"options": ["hysteresis", "overlap"]},
        }
    )  # fmt: skip
    (one,) = file.test
    found = ehamj.identify(file, measured={"valves": read_measured(record, one.measurement, mounts, one, "test")})
    assert found.choice.justified == ("overlap",)
    for key, value in ((f"{ISOLATOR}.overlap", 0.3), (f"{ISOLATOR}.flow_gain", 2.2e-6)):
        got = found.values[key]
        assert got.deviation is not None
        assert got.value == pytest.approx(value, abs=4.0 * got.deviation)
        assert got.deviation < 0.01 * value
    assert found.scenario.actuators["isolator"].overlap == pytest.approx(
        [found.values[f"{ISOLATOR}.overlap"].value] * 4
    )
    assert f"{ISOLATOR}.hysteresis" not in found.values
    print_found(found)
    said = " ".join(capsys.readouterr().out.split())
    assert "options of the valve" in said
    assert "overlap the data justify an overlap" in said
    found.save(tmp_path)
    page = (tmp_path / "identification.html").read_text(encoding="utf-8")
    assert "the data justify an overlap" in page
    assert "a hysteresis is not needed" in page

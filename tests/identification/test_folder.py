"""What an identification leaves: a machine that says what is known of it, numbers, samples, a study, a page."""

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr
from lxml import html

from ehamj.campaign.file import load_study
from ehamj.identification.histories import plain_name
from ehamj.identification.identify import identify
from ehamj.identification.outcome import Identification
from ehamj.measured.measured import Measured, MeasuredChannel
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

GAIN, OIL, YAW = "actuators.isolator.flow_gain", "actuators.isolator.bulk_modulus", "machine.inertia.2"
TRUE = {GAIN: 2.2e-6, OIL: 1.2e9}
BASE: dict[str, Any] = {"name": "rig", "plates": "tied", "compare": [], "engine": "small-motion"}
OUTPUTS = ("stroke front-left", "chamber_pressure rear-right 1")


def driven(phase: float) -> dict[str, Any]:
    """Valves that swing, each at frequencies of its own."""
    signals = [
        {"kind": "multisine", "mounts": [mount], "amplitude": 0.1, "frequencies": [5.0 + k, 21.0 + k, 47.0 + k],
         "phases": [phase, 2.0, 4.0]}
        for k, mount in enumerate(MOUNTS)
    ]  # fmt: skip
    return {"duration": 0.8, "record_rate": 500.0, "control": {"kind": "open-loop", "signals": signals}}


def measured(name: str, phase: float) -> Measured:
    """Such a test as a logger writes it: 1 % of noise, 16 bit."""
    isolator = {key.rpartition(".")[2]: value for key, value in TRUE.items()}
    run = simulate(parse_scenario({**BASE, **driven(phase), "actuators": {"isolator": isolator}}))
    log = logged(run, [Tap(channel=one, noise=0.01) for one in OUTPUTS], seed=1)
    columns = zip(log.names, log.units, strict=True)
    return Measured(name, log.rate, tuple(MeasuredChannel(one, unit, log[one]) for one, unit in columns))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> tuple[Identification, Path]:
    """An identification of two values that the data tell and one that they cannot, and its folder."""
    place = tmp_path_factory.mktemp("identified")
    (base := place / "rig.toml").write_text(parse_scenario(BASE).to_toml(), encoding="utf-8")
    table = {
        "title": "Rig",
        "scenario": str(base),
        "parameters": {GAIN: {}, OIL: {}, YAW: {}},
        "fit": {"starts": 1},
        "test": [
            {"name": "all valves", "kind": "record", "rate": 500.0, "set": driven(0.0)},
            {"name": "once more", "kind": "record", "rate": 500.0, "set": driven(1.0), "hold_out": True},
        ],
    }
    found = identify(
        table, measured={"all valves": measured("all valves", 0.0), "once more": measured("once more", 1.0)}
    )
    (out := place / "out").mkdir()
    found.save(out)
    return found, out


def test_its_scenario_is_the_machine_with_what_is_known_of_it(folder: tuple[Identification, Path]) -> None:
    found, place = folder
    scenario = load_scenario(place / "scenario.toml")
    isolator = scenario.actuators["isolator"]
    for key, true in TRUE.items():
        name = key.rpartition(".")[2]
        spread = cast(float, isolator.deviations[name])
        assert isolator.sources[name] == "identified"
        assert spread == found.values[key].deviation
        assert abs(getattr(isolator, name) - true) < 4.0 * spread < 0.05 * true
    assert set(isolator.deviations) == {"flow_gain", "bulk_modulus"}
    assert found.values[YAW].value is None
    assert (scenario.machine.inertia[2], scenario.machine.deviations) == (4000.0, {})
    assert scenario == found.scenario


def test_its_samples_open_with_xarray(folder: tuple[Identification, Path]) -> None:
    found, place = folder
    with xr.open_dataset(place / "identification.nc", engine="h5netcdf") as about:
        assert about["value"].sel(parameter=GAIN) == found.values[GAIN].value
        assert np.isnan(about["value"].sel(parameter=YAW))
    for test, held in ((found.tests[0], 0), (found.validation[0], 1)):
        with xr.open_dataset(place / "identification.nc", group=plain_name(test.name), engine="h5netcdf") as dataset:
            assert dataset.attrs["held_out"] == held
            for channel in test.channels:
                column = dataset[f"{plain_name(channel.name)}_measured"]
                assert column.attrs["units"] == channel.unit
                np.testing.assert_array_equal(column.time, channel.at)
                np.testing.assert_array_equal(column, channel.measured)


def test_its_study_draws_machines_as_the_data_leave_them_open(folder: tuple[Identification, Path]) -> None:
    found, place = folder
    study = load_study(place / "robustness.toml")
    assert set(study.vary) == set(TRUE)
    machine = study.machine
    assert study.vary[GAIN].quantiles(np.array(0.5), None) == pytest.approx(found.values[GAIN].value)
    upper = study.vary[OIL].quantiles(np.array(0.841345), None) - found.values[OIL].value  # one deviation above
    assert upper == pytest.approx(found.values[OIL].deviation, rel=1e-3)
    assert machine.scenario.actuators["isolator"].flow_gain == found.values[GAIN].value


def test_its_page_shows_all_of_it(folder: tuple[Identification, Path]) -> None:
    found, place = folder
    page = html.fromstring((place / "identification.html").read_text(encoding="utf-8"))
    said = page.xpath('string(//ul[@id="verdict"])')
    assert "2 of 3 values told by the data" in said
    assert "inertia z" in said
    rows = {row.xpath("string(th//code)"): row for row in page.xpath('//section[@id="values"]//tbody/tr')}
    assert list(rows) == list(found.values)
    assert rows[YAW].xpath("string(td[1])") == "–"
    assert "not told" in rows[YAW].text_content()
    assert "identified" in rows[GAIN].text_content()
    assert found.combinations[0].words in page.xpath('string(//section[@id="cannot-tell"])')
    channels = page.xpath('//section[@id="fit"]//tbody/tr')
    assert [row.xpath("string(td[1])") for row in channels] == [*OUTPUTS, *OUTPUTS]
    assert "held out" in channels[2].xpath("string(th)")
    assert page.xpath('//section[starts-with(@id, "test-")]//figure')
    assert len(list((place / "figures").glob("*.svg"))) == len(page.xpath("//figure"))


def test_its_numbers_are_json(folder: tuple[Identification, Path]) -> None:
    found, place = folder
    numbers = json.loads((place / "identification.json").read_text(encoding="utf-8"))
    assert numbers["values"][GAIN]["value"] == found.values[GAIN].value
    assert numbers["values"][YAW]["status"] == "unidentifiable"

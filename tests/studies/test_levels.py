"""Attenuation against the floor's level: what the study runs, and that it degrades gracefully."""

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario
from ehamj.studies.levels import LevelSettings, levels
from ehamj.studies.outcome import Outcome

CHOSEN = ("VC-D", "operating theatre")


@pytest.fixture(scope="module")
def found() -> Outcome:
    return levels(load_scenario("vc-c-floor"), LevelSettings(levels=CHOSEN, duration=6.0))


def test_both_laws_run_at_every_level(found: Outcome) -> None:
    table = found.tables["levels"]
    assert table.attenuation.shape == (2, 2, 6)
    assert list(table.law.values) == ["everywhere", "from 5 Hz"]
    assert all(variable.attrs.get("long_name") for variable in table.variables.values())


def test_on_a_quiet_floor_nothing_clips_and_ten_hertz_are_quiet(found: Outcome) -> None:
    one = found.tables["levels"].sel(level="VC-D", law="everywhere")
    assert float(one.clipped) == 0.0
    # 55 dB: the acceptance at VC-C is 52; less floor, less turbulent flow.
    assert float(one.attenuation.sel(band=10.0)) > 55.0


def test_isolating_from_later_on_costs_less_voltage(found: Outcome) -> None:
    command = found.tables["levels"].sel(level="VC-D").command
    # 3.7 of 5.9 V by design (`ehamj.control.lowend`); 6 s of a floor scatter.
    assert float(command.sel(law="from 5 Hz")) < 0.75 * float(command.sel(law="everywhere"))


def test_a_floor_too_strong_clips_without_a_limit_cycle_or_warp(found: Outcome) -> None:
    table = found.tables["levels"].sel(level="operating theatre")
    assert float(table.clipped.min()) > 0.05
    # Clipped, the machine is hardly quieter, but a limit cycle would make it louder.
    assert np.nanmin(table.attenuation.sel(band=[2.0, 5.0, 10.0, 20.0]).values) > -1.0
    assert float(table.warp.max()) < 0.02


@pytest.mark.parametrize(("key", "value"), [("levels", ("VC-Z",)), ("duration", 1.0)])
def test_what_cannot_be_run_is_refused(key: str, value: object) -> None:
    with pytest.raises(InputError, match=key):
        levels.with_settings({key: value})

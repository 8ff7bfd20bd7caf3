"""What the report says of valves that a law makes good."""

import numpy as np
import pytest

from ehamj.report.sections.valves import valves
from ehamj.report.shown import Shown
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

QUICK = ("duration=0.3", "engine=small-motion", "plates=tied")


@pytest.fixture(scope="module")
def real() -> Scenario:
    return load_scenario("real-valves", QUICK)


def test_what_the_law_believes_stands_beside_what_is_so(real: Scenario) -> None:
    off = real.varied({"control.linearisation": {"overlap": 0.8, "supply": "stated"}})
    section = valves(Shown.of({"off": simulate(off), "passive": simulate(real.variant("passive"))}))
    assert section is not None
    beliefs, spools = section.tables
    found = {row[0]: row[1:] for row in beliefs.rows}
    assert found["overlap 1–tank [mA]"] == ["0.400 (0.320)"]
    assert found["half of hysteresis, with threshold [mA]"] == ["0.0900"]
    assert found["supply"] == ["stated, 70 bar"]
    assert spools.rows[0] == ["off"]  # of several runs each under its name; the passive one commands nothing
    assert ["passive"] not in spools.rows


def test_a_spool_stands_from_the_ideal_opening_by_what_the_valve_is(real: Scenario) -> None:
    """Beyond its overlap of 0.4 mA; of a linear valve by the load's part of the pressure drop only, some per cent."""
    lapped = real.varied({"actuators.isolator.valve": "paper", "actuators.isolator.air_fraction": 0.0})
    lapped = lapped.varied({"supply.dynamic": False, "actuators.isolator.overlap": [0.4] * 4})
    for overlap, run in ((0.0, simulate(real.variant("ideal-valves"))), (0.4, simulate(lapped))):
        section = valves(Shown.of({"run": run}))
        assert section is not None
        _, ideal, apart = (np.array([float(cell) for cell in row[1:]]) for row in section.tables[1].rows)
        assert np.all(ideal > 0.4)  # it opens, and rarely stands within the overlap
        np.testing.assert_allclose(apart, overlap, atol=0.1 * float(ideal.max()))


def test_a_law_that_makes_nothing_good_has_no_section(real: Scenario) -> None:
    assert valves(Shown.of({"run": simulate(real.variant("without-linearisation"))})) is None

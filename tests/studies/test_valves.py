"""What imperfections of valves cost."""

import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario
from ehamj.studies.catalogue import study

BY_HAND = "control={kind='combined', delay=1.5e-4}"
"""The law that the costs below are of: one that leaves less by itself loses more to the same imperfection."""
SCENARIO = load_scenario("vc-c-floor", ["compare=[]", "plates=tied", BY_HAND])


def test_overlap_costs_without_linearisation_and_hardly_with_it() -> None:
    """2 % of the stroke at 20 and 50 Hz, where it costs most; the trend is asserted, not the level of a short run."""
    off = {"hysteresis": 0.0, "threshold": 0.0, "flow_curve": False, "air_fraction": 0.0, "shared_pump": False}
    found = study("valves", SCENARIO, duration=3.0, band=20.0, **off)
    assert found.tables["attenuation"]["case"].values.tolist() == ["ideal", "overlap"]
    cost = found.tables["cost"].sel(case="overlap")
    for band in (20.0, 50.0):
        assert float(cost["without"].sel(band=band)) > 20.0
        assert float(cost["with"].sel(band=band)) < 12.0
    assert "With overlap: " in found.answers[1]
    assert found.answers[2].startswith("Across the overlap, believed as it is: the valve's gain is up to 1.0")
    left = found.tables["across"].sel(overlap="30 % too large")
    assert float(left["gain_margin"].min()) < float(left["gain_margin"][-1]) - 1.0  # the most at some amplitude
    for law, one in found.numbers.items():
        assert one["overlap"]["20"] == pytest.approx(float(found.tables["attenuation"].sel(
            law=law.split()[0], case="overlap", band=20.0)["attenuation"]))  # fmt: skip


def test_a_study_of_no_law_and_of_no_such_band_are_refused() -> None:
    with pytest.raises(InputError, match=r"control\.kind = 'passive'"):
        study("valves", SCENARIO.variant("passive"))
    with pytest.raises(InputError, match="band = 7 Hz: must be one of 5, 10"):
        study("valves", SCENARIO, band=7.0)

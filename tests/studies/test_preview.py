"""What metres buy upstream."""

import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario
from ehamj.studies.catalogue import study

SCENARIO = load_scenario("vc-c-floor", ["compare=[]", "plates=tied"])


def test_metres_buy_voltage_and_what_the_voltage_buys() -> None:
    """On a VC-A floor, of which less is clipped; the trend is asserted, not the level of a short run."""
    found = study("preview", SCENARIO, levels=("VC-A",), metres=(20.0,), duration=6.0, off=0.05)
    own = found.tables["preview"].sel(level="VC-A", belief="right")
    assert float(own["command"].sel(metres=20.0)) < 0.75 * float(own["command"].sel(metres=0.0))
    for band in (10.0, 20.0):
        without, with_it = (float(own["attenuation"].sel(metres=metres, band=band)) for metres in (0.0, 20.0))
        assert with_it > without + 5.0
    wrong = found.tables["preview"].sel(level="VC-A", belief="wrong", metres=20.0)
    for band in (5.0, 10.0, 20.0):  # above isolate_from the local sensors know better
        assert float(wrong["attenuation"].sel(band=band)) == pytest.approx(
            float(own["attenuation"].sel(metres=20.0, band=band)), abs=1.5
        )
    assert found.answers[1].startswith("VC-A, a sensor 20 m upstream: ")


def test_a_law_that_cannot_be_told_where_isolation_begins_is_refused() -> None:
    with pytest.raises(InputError, match=r"control\.kind = 'passive'"):
        study("preview", SCENARIO.variant("passive"))
    with pytest.raises(InputError, match=r"control\.kind = 'levelling': cannot be told where isolation begins"):
        study("preview", load_scenario("vc-c-floor", ["control={kind='levelling'}", "compare=[]"]))

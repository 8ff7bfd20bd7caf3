"""Names of merits as a list: those of one kind in one line, and each that has a word in it."""

import pytest

from ehamj.errors import InputError
from ehamj.merits.listing import listing
from ehamj.merits.merit import Merit
from ehamj.scenario.load import load_scenario

SCENARIO = load_scenario("benchmark")
NAMES = (
    "passive.frequency.heave", "passive.frequency.upper-about-x", "loop.gain_margin",
    "loop.gain_margin.valve-rear-left", "loop.gain_margin.warp", "run.attenuation_db.z.31.5",
    "run.attenuation_db.rx.10", "run.below.VC-F.z", "actuator.isolator.bandwidth",
    "loop.disk_margin.reading-stroke-rear-left",
)  # fmt: skip
MERITS = {name: Merit(name, "dB", f"text of {name}") for name in NAMES}


def test_names_of_one_kind_stand_in_one_line_which_the_first_of_them_tells() -> None:
    found = listing(MERITS, SCENARIO)
    assert list(found) == [
        "passive.frequency.MODE", "loop.gain_margin", "loop.gain_margin.MOUNT", "loop.gain_margin.MODE",
        "run.attenuation_db.AXIS.BAND", "run.below.CLASS.AXIS", "actuator.ACTUATOR.bandwidth",
        "loop.disk_margin.READING",
    ]  # fmt: skip
    assert found["run.attenuation_db.AXIS.BAND"].text == "text of run.attenuation_db.z.31.5"


def test_a_word_finds_each_name_by_itself() -> None:
    assert list(listing(MERITS, SCENARIO, "attenuation")) == ["run.attenuation_db.z.31.5", "run.attenuation_db.rx.10"]
    with pytest.raises(InputError, match="'weight'"):
        listing(MERITS, SCENARIO, "weight")

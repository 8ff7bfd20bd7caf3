"""What is said beside a refusal: the word that was meant, the key as a user writes it, and the way out."""

import re
from pathlib import Path

import pytest

from ehamj.control import Controller
from ehamj.errors import InputError, did_you_mean
from ehamj.mujoco import hydraulics
from ehamj.run.prepare import prepare
from ehamj.scenario.load import load_scenario
from ehamj.studies.catalogue import STUDIES
from ehamj.synthesis.settings import SynthesisSettings


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["control.kind=lqgg"], "control.kind = 'lqgg': did you mean 'lqg'? must be one of 'passive'"),
        (["ground.kind=sin"], "ground.kind = 'sin': did you mean 'sine'?"),
        (["actuators.isolator.preset=recomended"], "preset = 'recomended': did you mean 'recommended'?"),
        (["criteria.norms=['nist']"], "criteria.norms.0 = 'nist': did you mean 'nist-a'?"),
        (["compare=['passiv']"], "compare.0 = 'passiv': did you mean 'passive'?"),
        (["engine=smallmotion"], "engine = 'smallmotion': did you mean 'small-motion'?"),
        (["fault=[{kind='valve-stuk', time=1, mount='rear-left'}]"], "did you mean 'valve-stuck'?"),
        (["fault=[{kind='valve-stuck', time=1, mount='rear-lef'}]"], "did you mean 'rear-left'?"),
        (["force=[{kind='sine', amplitude=1, frequency=9, point='spindle-nos'}]"], "did you mean 'spindle-nose'?"),
        (["sensors.inertial=geophone"], "must be a table, such as { kind = 'geophone' }"),
        (["control.parts.0.gain=0.9"], "an entry of it is set by its number only where the scenario states the list"),
    ],
)
def test_the_word_that_was_meant_is_named(overrides: list[str], said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        load_scenario("recorded", overrides)


def test_scenarios_and_studies_are_meant_too() -> None:
    with pytest.raises(InputError, match="did you mean 'vc-c-floor'"):
        load_scenario("vc-c-flor")
    with pytest.raises(InputError, match="did you mean 'tolerances'"):
        STUDIES.find("tolerence")


def test_what_is_like_nothing_is_no_hint() -> None:
    assert did_you_mean("zzz", ("alpha", "beta")) == ""


def test_keys_that_stayed_from_another_kind_have_a_way_out() -> None:
    with pytest.raises(InputError, match=r"was of kind 'lqg'.*--set 'control=\{kind=\"passive\"\}'") as refused:
        load_scenario("vc-c-floor", ["control.kind=passive"])
    (way_out,) = re.findall(r"--set '(.*)'", str(refused.value))
    assert load_scenario("vc-c-floor", [way_out]).control.kind == "passive"
    with pytest.raises(InputError) as another:
        load_scenario("vc-c-floor", ["control.delai=1e-4"])
    assert "begin anew" not in str(another.value)


def test_a_message_of_a_part_names_the_key_that_it_has_in_the_sum() -> None:
    parts = "control={kind='combined', parts=[{kind='modal'}, {kind='resonant', lines=[6000.0]}]}"
    with pytest.raises(InputError, match=r"^control\.parts\.1\.lines: 6000 Hz must be below half of control\.rate"):
        load_scenario("recorded", [parts]).controller()


def test_a_finding_of_a_whole_table_names_the_key_in_it() -> None:
    with pytest.raises(InputError, match=r"^control\.parts\.0\.rate = 5000\.0: must be that of the whole"):
        load_scenario("recorded", ["control={kind='combined', parts=[{kind='modal', rate=5000}]}"])


def test_one_weight_of_a_synthesis_is_set_alone() -> None:
    before, after = (load_scenario("vc-c-floor", of).control for of in ([], ["control.roll.bandwidth=100"]))
    assert isinstance(before, SynthesisSettings)
    assert isinstance(after, SynthesisSettings)
    assert after.roll == before.roll.model_copy(update={"bandwidth": 100.0})
    assert after.heave == before.heave
    alone = load_scenario("vc-c-floor", ["control.feedforward.gain=0.9"]).control
    assert isinstance(alone, SynthesisSettings)
    assert alone.feedforward.rolloff == before.feedforward.rolloff


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["timestep=1e-4"], r"the period of control\.spool_feedback = 3\.33333e-05 s; nearest: 3\.33333333e-05$"),
        (
            ["control.spool_feedback.rate=17777.7", "record_rate=1000"],
            r"choose record_rate, control\.rate and control\.spool_feedback\.rate that are multiples",
        ),
    ],
)
def test_a_step_that_fits_no_rate_of_the_spools_is_told_which_rates_to_choose(overrides: list[str], said: str) -> None:
    fast = ["control={kind='feedforward'}", "control.spool_feedback.rate=30000", "plates=tied", "compare=[]"]
    scenario = load_scenario("recorded", [*fast, *overrides])
    with hydraulics(), pytest.raises(InputError, match=said):
        prepare(scenario, None)


def test_a_step_that_fits_no_rate_of_a_law_is_told_what_its_rate_is_called_there(tmp_path: Path) -> None:
    shared = ["plates=tied", "compare=[]", "record_rate=1000", "control={kind='feedforward', rate=17777.7}"]
    own = load_scenario("recorded", shared)
    law = own.controller()
    assert isinstance(law, Controller)
    law.save(tmp_path / "law.json")
    filed = load_scenario("recorded", [*shared[:3], f"control={{kind='law', file='{tmp_path / 'law.json'}'}}"])
    for scenario, given, called in (
        (own, None, r"control\.rate"),
        (own, law, "1/period of the controller"),
        (filed, None, "1/period_s of the law's file"),
    ):
        with hydraulics(), pytest.raises(InputError, match=f"choose record_rate and {called} that are multiples"):
            prepare(scenario, given)


def test_spools_that_are_read_exactly_are_told_of() -> None:
    own = ["control={kind='feedforward', spool_feedback=true}", "plates=tied", "ground={kind='rest'}"]
    for more, told in (([], True), (["sensors.spool={}"], False), (["sensors.spool={noise=0.0}"], True)):
        with hydraulics():
            notes = prepare(load_scenario("recorded", [*own, "duration=0.01", *more]), None).notes
        assert any("reads where the spools stand exactly" in note for note in notes) is told

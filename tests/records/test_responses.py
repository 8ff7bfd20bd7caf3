"""What an instrument senses, in any unit; its stages against its sensitivity; inventories and poles and zeros."""

import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from obspy.core.inventory import Response
from obspy.core.inventory.response import (
    CoefficientsTypeResponseStage,
    InstrumentSensitivity,
    PolesZerosResponseStage,
    ResponseListElement,
    ResponseListResponseStage,
)
from oracles.records import motion, read
from oracles.seismic import BEGIN, TAU, flat, inventory, metadata, trace, write
from scipy import signal

COUNTS = (20000 * np.sin(TAU * 10 * np.arange(2500) / 250)).astype(np.int32)
"""What the sensors below make of 1e-6 m at 10 Hz."""
MOTION = [1e-6 * (TAU * 10) ** order for order in range(3)]
"""Amplitude of displacement, velocity and acceleration in SI."""
PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2}
SPELLINGS = (
    ("{}", "({})", "[{}]"),
    ("{}/s", "{}/sec", "({}/s)", "{} s-1", "{}·s⁻¹", "{} / S", "{}/second"),
    ("{}/s^2", "{}/s**2", "{}/s2", "{}/s²", "{}/sec/sec", "{}/s/s", "({}/s^2)", "{}/(s**2)", "{} s-2", "{}·s⁻²",
     "{}/SEC**2"),
)  # fmt: skip
SPELLED = [(order, spelling) for order, spellings in enumerate(SPELLINGS) for spelling in spellings]
NAMED = [("g", 9.80665), ("G", 9.80665), ("mg", 9.80665e-3), ("Gal", 1e-2), ("in/s^2", 0.0254), ("gn", 9.80665)]


def response_at(path: Path, xml: Path, frequency: float = 10.0, **choices: Any) -> tuple[complex, str, tuple[str, ...]]:
    """Counts per SI unit at a frequency, quantity, and notes."""
    record = read(path, inventory=str(xml), axes={"HHZ": "z"}, **choices)
    channel = record.channels[0]
    assert channel.response is not None
    return complex(channel.response(np.array([frequency]))[0]), channel.quantity, record.notes


@pytest.fixture(scope="module")
def counts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("counts") / "a.mseed", trace(COUNTS, rate=250.0))


@given(st.sampled_from(SPELLED), st.sampled_from(sorted(PREFIXES)), st.booleans())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=120)
def test_every_spelling_of_every_unit_is_the_same_motion(
    counts: Path, tmp_path: Path, spelled: tuple[int, str], prefix: str, upper: bool
) -> None:
    order, spelling = spelled
    unit = spelling.format(f"{prefix}m")
    unit = unit.upper().replace("Μ", "µ") if upper else unit
    stated = MOTION[order] / PREFIXES[prefix]
    xml = metadata(tmp_path / "a.xml", flat(20000 / stated, unit))
    found, quantity, _ = response_at(counts, xml)
    assert quantity == ("displacement", "velocity", "acceleration")[order]
    # Counts per SI, by hand; rounding of the digits that StationXML keeps.
    assert found == pytest.approx(20000 / MOTION[order], rel=1e-6)


@pytest.mark.parametrize(("unit", "size"), NAMED)
def test_named_units_of_acceleration(counts: Path, tmp_path: Path, unit: str, size: float) -> None:
    xml = metadata(tmp_path / "a.xml", flat(20000 * size / MOTION[2], unit))
    found, quantity, _ = response_at(counts, xml)
    assert (quantity, found) == ("acceleration", pytest.approx(20000 / MOTION[2], rel=1e-6))


@pytest.mark.parametrize("unit", ["RAD/S", "PA", "C", "V", "T", "M/S**3", "counts", "wombats"])
def test_what_is_no_motion_is_refused_by_name(counts: Path, tmp_path: Path, unit: str) -> None:
    with pytest.raises(ValueError, match=rf"ground\.inventory: XX\.ONE\.\.HHZ senses '{unit.replace('*', '.')}'"):
        response_at(counts, metadata(tmp_path / "a.xml", flat(1e9, unit)))


@pytest.mark.parametrize("unit", ["M/S", "m/s", "M/S**2", "m/s^2", "M/S2", "M/SEC/SEC", "NM/S", "CM/SEC**2"])
def test_obspys_own_files_give_the_floor_that_was_felt(tmp_path: Path, unit: str) -> None:
    # As ObsPy writes them: its overall sensitivity of NM/S is per m/s. 0.5 %: what the sine's ends leave.
    order = 1 if unit.count("/") == 1 and unit.lower().endswith("/s") else 2
    stated = MOTION[order] * {"NM/S": 1e9, "CM/SEC**2": 1e2}.get(unit, 1.0)
    samples = (20000 * np.sin(TAU * 10 * np.arange(7500) / 250)).astype(np.int32)
    write(tmp_path / "a.mseed", trace(samples, rate=250.0))
    made = Response.from_paz([], [], stage_gain=20000 / stated, input_units=unit, output_units="COUNTS")
    metadata(tmp_path / "a.xml", made)
    moved = motion(tmp_path, "a.mseed", inventory="a.xml", start=12.0)
    time = np.arange(1.5, 4.5, 1e-3)  # after the fade
    found = moved.sample(time).displacement[:, 0, 2]
    amplitude = 2 * abs(np.mean(found * np.exp(-1j * TAU * 10 * time)))
    assert amplitude == pytest.approx(1e-6, rel=5e-3)


# --- stages and sensitivity ---------------------------------------------------------------------------------------


def test_stages_and_sensitivity_that_disagree_are_both_named(counts: Path, tmp_path: Path) -> None:
    xml = metadata(tmp_path / "a.xml", flat(1e8, "M/S", 30e8))
    with pytest.raises(ValueError, match=r"3e\+09 counts per 'M/S', its stages make 1e\+08 .*ground\.response"):
        response_at(counts, xml)
    for choice, gain in (("stages", 1e8), ("sensitivity", 30e8)):
        found, _, notes = response_at(counts, xml, response=choice)
        assert found == pytest.approx(gain, rel=1e-9)
        assert any("3e+09" in note and "1e+08" in note for note in notes)


@pytest.mark.parametrize(("ratio", "said"), [(1.005, False), (1.03, True), (0.97, True)])
def test_small_differences_are_said_at_most(counts: Path, tmp_path: Path, ratio: float, said: bool) -> None:
    found, _, notes = response_at(counts, metadata(tmp_path / "a.xml", flat(1e8, "M/S", ratio * 1e8)))
    assert found == pytest.approx(1e8, rel=1e-9)
    assert any("overall sensitivity" in note for note in notes) == said


def test_sensitivity_in_another_unit_is_compared_in_si(counts: Path, tmp_path: Path) -> None:
    found, _, notes = response_at(counts, metadata(tmp_path / "a.xml", flat(1e8, "M/S", 1e5, "MM/S")))
    assert found == pytest.approx(1e8)
    assert not any("sensitivity" in note for note in notes)
    with pytest.raises(ValueError, match=r"sense 'M/S', but its overall sensitivity is per 'M/S\*\*2'"):
        response_at(counts, metadata(tmp_path / "a.xml", flat(1e8, "M/S", 1e8, "M/S**2")))


def test_the_shape_of_the_stages_is_kept_when_scaled(counts: Path, tmp_path: Path) -> None:
    omega = TAU * 4.5
    poles = list(omega * np.roots([1.0, 1.2, 1.0]))
    made = Response.from_paz([0j, 0j], poles, stage_gain=2e7, stage_gain_frequency=50.0, output_units="COUNTS")
    made.instrument_sensitivity = InstrumentSensitivity(4e7, 10.0, "M/S", "COUNTS")
    xml = metadata(tmp_path / "a.xml", made)
    _, shape = signal.freqs_zpk([0, 0], poles, 1.0, TAU * np.array([2.0, 10.0]))
    for frequency, value in zip((2.0, 10.0), shape, strict=True):
        found, _, _ = response_at(counts, xml, frequency, response="sensitivity")
        assert found == pytest.approx(4e7 * value / abs(shape[1]), rel=1e-6)


def test_a_sensitivity_alone_suffices(counts: Path, tmp_path: Path) -> None:
    xml = metadata(
        tmp_path / "a.xml", Response(instrument_sensitivity=InstrumentSensitivity(5e8, 1.0, "mm/s", "COUNTS"))
    )
    found, quantity, notes = response_at(counts, xml)
    assert (found, quantity) == (pytest.approx(5e11), "velocity")
    assert any("taken as flat, without poles" in note for note in notes)
    with pytest.raises(ValueError, match=r'"stages", but the metadata of .* have a sensitivity only'):
        response_at(counts, xml, response="stages")


def test_sensitivity_is_not_chosen_where_there_is_none(counts: Path, tmp_path: Path) -> None:
    made = flat(1e8, "M/S")
    made.instrument_sensitivity = None
    xml = metadata(tmp_path / "a.xml", made)
    assert response_at(counts, xml)[0] == pytest.approx(1e8)
    with pytest.raises(ValueError, match=r'"sensitivity", but the metadata of .* state no overall sensitivity'):
        response_at(counts, xml, response="sensitivity")


# --- what is said -------------------------------------------------------------------------------------------------


def two_stages(given: str = "V", taken: str = "V") -> Response:
    made = flat(1e2, "M/S", 1e8)
    made.response_stages[0].output_units = given
    made.response_stages.append(
        CoefficientsTypeResponseStage(
            2, 1e6, 1.0, taken, "COUNTS", "DIGITAL", numerator=[1.0], denominator=[], decimation_factor=1,
            decimation_input_sample_rate=250.0, decimation_offset=0, decimation_delay=0.0, decimation_correction=0.0,
        )
    )  # fmt: skip
    return made


def test_what_obspy_and_c_code_say_becomes_a_note(
    counts: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    xml = metadata(tmp_path / "a.xml", two_stages())
    assert not any("ObsPy says" in note for note in response_at(counts, xml)[2])
    plain = Response.get_evalresp_response_for_frequencies

    def talking(self: Response, *arguments: Any, **options: Any) -> Any:
        os.write(2, b"<< EVALRESP >> WARNING (analog_trans): Numerical\n")  # as C does, past Python
        os.write(2, b"of somebody else\n")
        warnings.warn("the moon is full", stacklevel=1)
        return plain(self, *arguments, **options)

    monkeypatch.setattr(Response, "get_evalresp_response_for_frequencies", talking)
    _, _, notes = response_at(counts, xml)
    for said in ("WARNING (analog_trans): Numerical", "the moon is full"):
        assert sum("XX.ONE..HHZ: of its response ObsPy says:" in note and said in note for note in notes) == 1
    assert set(capfd.readouterr().err.splitlines()) == {"of somebody else"}


def test_stages_lead_into_each_other(counts: Path, tmp_path: Path) -> None:
    assert response_at(counts, metadata(tmp_path / "a.xml", two_stages("V", "volts")))[0] == pytest.approx(1e8)
    with pytest.raises(ValueError, match=r"stage 1 of XX\.ONE\.\.HHZ gives 'V', and the next takes 'mV'"):
        response_at(counts, metadata(tmp_path / "a.xml", two_stages("V", "mV")))


def test_a_response_that_ends_in_volts_suits_no_counts(counts: Path, tmp_path: Path) -> None:
    made = flat(1e2, "M/S")
    made.response_stages[0].output_units = "V"
    xml = metadata(tmp_path / "a.xml", made)
    with pytest.raises(ValueError, match=r"ends in 'V', not in counts: a stage is missing"):
        response_at(counts, xml)
    volts = write(tmp_path / "v.mseed", trace(COUNTS * 1e-5, rate=250.0))
    found, _, notes = response_at(volts, xml)
    assert found == pytest.approx(1e2)
    assert any("taken as volts" in note for note in notes)


def test_a_listed_response_ends_where_its_list_ends(counts: Path, tmp_path: Path) -> None:
    made = flat(1e8, "M/S")
    rows = [ResponseListElement(f, 2.0, 0.0) for f in (1.0, 2.0, 5.0, 10.0, 20.0)]
    made.response_stages = [ResponseListResponseStage(1, 5e7, 1.0, "M/S", "COUNTS", response_list_elements=rows)]
    xml = metadata(tmp_path / "a.xml", made)
    found, _, notes = response_at(counts, xml)
    assert found == pytest.approx(1e8, rel=1e-6)
    assert response_at(counts, xml, 40.0)[0] == 0
    assert any("listed from 1 to 20 Hz" in note for note in notes)


def test_a_gain_without_frequency_still_counts(counts: Path, tmp_path: Path) -> None:
    made = flat(1e8, "M/S")
    stage = made.response_stages[0]
    assert isinstance(stage, PolesZerosResponseStage)
    stage.stage_gain_frequency = None
    path = tmp_path / "a.xml"
    text = metadata(path, flat(1e8, "M/S")).read_text()
    path.write_text(text.replace("<Frequency>1.0</Frequency>\n            </StageGain>", "</StageGain>"))
    assert response_at(counts, path)[0] == pytest.approx(1e8)


# --- which response -----------------------------------------------------------------------------------------------


def test_messages_list_what_an_inventory_holds(counts: Path, tmp_path: Path) -> None:
    made = flat(1e8, "M/S")
    for k, (held, message) in enumerate(
        (
            ([("HHN", made, None, None)], r"no response of XX\.ONE\.\.HHZ at 2026-.*it holds XX\.ONE\.\.HHN \("),
            ([("HHZ", made, BEGIN + 5, None)], r"no epoch of .*holds XX\.ONE\.\.HHZ \(2026-01-05T00:00:05 to …\)"),
            ([("HHZ", made, None, None)] * 2, r"more than one response of"),
            ([("HHZ", None, None, None)], r"names, but has no response of, XX\.ONE\.\.HHZ"),
            ([(f"H{k}", made, None, None) for k in "ABCDEFGHIJK"], r"HH \(.* to …\) and 3 more$"),
        )
    ):
        with pytest.raises(ValueError, match=message):
            response_at(counts, inventory(tmp_path / f"{k}.xml", *held))
    xml = inventory(tmp_path / "a.xml", ("HHZ", made, None, None), ("HHN", made, None, None), location="00")
    with pytest.raises(ValueError, match=r"no response of .*holds XX\.ONE\.00\.HHZ \(… to …\)$"):
        response_at(counts, xml)


def test_the_epoch_at_the_records_begin_counts(counts: Path, tmp_path: Path) -> None:
    xml = inventory(
        tmp_path / "a.xml", ("HHZ", flat(1e7, "M/S"), None, BEGIN), ("HHZ", flat(1e8, "M/S"), BEGIN, BEGIN + 9.5)
    )
    found, _, notes = response_at(counts, xml)
    assert found == pytest.approx(1e8)
    assert any("ends at 2026-01-05T00:00:09.500000, within the record; it is used for" in note for note in notes)


def test_a_response_that_changes_within_the_record_is_refused(counts: Path, tmp_path: Path) -> None:
    one, two = flat(1e7, "M/S"), flat(2e7, "M/S")
    xml = inventory(tmp_path / "a.xml", ("HHZ", one, BEGIN - 9, BEGIN + 5), ("HHZ", two, BEGIN + 5, None))
    both = (
        r"XX\.ONE\.\.HHZ \(2026-01-04T23:59:51 to 2026-01-05T00:00:05\) to XX\.ONE\.\.HHZ \(2026-01-05T00:00:05 to …\)"
    )
    with pytest.raises(ValueError, match=rf"HHZ changes at 2026-01-05T00:00:05, within .*{both}; cut the record's"):
        response_at(counts, xml)
    xml = inventory(tmp_path / "a.xml", ("HHZ", one, BEGIN - 9, BEGIN + 5))
    with pytest.raises(ValueError, match=r"ends at 2026-01-05T00:00:05, within the record .*no other follows"):
        response_at(counts, xml)
    (tmp_path / "a.pz").write_text(
        sacpz(1e7, **NAMES, START="2000-01-01T00:00:00", END="2026-01-05T00:00:05")
        + sacpz(2e7, **NAMES, START="2026-01-05T00:00:05", END="")
    )
    with pytest.raises(ValueError, match=r"HHZ changes at 2026-01-05T00:00:05, within .* to …\); cut the record's"):
        response_at(counts, tmp_path / "a.pz")


# --- poles and zeros ----------------------------------------------------------------------------------------------

POLES = TAU * 4.5 * np.roots([1.0, 1.2, 1.0])


def sacpz(constant: float = 3e7, zeros: int = 3, **comments: str) -> str:
    stars = "* **********************************\n"
    head = "".join(f"* {key.replace('_', ' '):<18}: {value}\n" for key, value in comments.items())
    roots = "".join(f"\t{p.real:+.6e}\t{p.imag:+.6e}\n" for p in POLES)
    if not head:
        return f"ZEROS {zeros}\nPOLES 2\n{roots}CONSTANT {constant:e}\n"
    return f"{stars}{head}{stars}ZEROS\t{zeros}\n\t0.0 0.0\nPOLES\t2\n{roots}CONSTANT\t{constant:e}\n\n\n"


NAMES = {"NETWORK": "XX", "STATION": "ONE", "LOCATION": "", "CHANNEL": "HHZ"}


@pytest.mark.parametrize(
    ("comments", "order", "size"),
    [
        ({}, 0, 1.0),
        (NAMES, 0, 1.0),
        (NAMES | {"INPUT_UNIT": "M", "OUTPUT_UNIT": "COUNTS"}, 0, 1.0),
        (NAMES | {"INPUT_UNIT": "NM"}, 0, 1e-9),
        (NAMES | {"INPUT_UNIT": "M/S"}, 1, 1.0),
        (NAMES | {"INPUT_UNIT": "M/S**2", "LOCATION": "--"}, 2, 1.0),
    ],
)
def test_poles_and_zeros_are_their_closed_form(
    counts: Path, tmp_path: Path, comments: dict[str, str], order: int, size: float
) -> None:
    path = tmp_path / "a.pz"
    path.write_text(sacpz(zeros=3 - order, **comments))
    frequencies = np.array([0.5, 4.5, 10.0, 80.0])
    channel = read(counts, inventory=str(path), axes={"HHZ": "z"}).channels[0]
    assert channel.response is not None
    _, expected = signal.freqs_zpk(np.zeros(3 - order), POLES, 3e7 / size, TAU * frequencies)
    np.testing.assert_allclose(channel.response(frequencies), expected, rtol=1e-6)  # seven digits in the file
    assert channel.quantity == ("displacement", "velocity", "acceleration")[order]


def test_poles_and_zeros_give_the_motion_that_was_felt(tmp_path: Path) -> None:
    time = np.arange(7500) / 250
    _, gain = signal.freqs_zpk(np.zeros(3), POLES, 3e9, [TAU * 10])
    felt = abs(gain[0]) * 1e-6 * np.sin(TAU * 10 * time + np.angle(gain[0]))
    write(tmp_path / "a.mseed", trace(felt.round().astype(np.int32), rate=250.0))
    (tmp_path / "a.pz").write_text(sacpz(3e9, **NAMES))
    moved = motion(tmp_path, "a.mseed", inventory="a.pz", start=12.0)
    query = np.arange(1.5, 4.5, 1e-3)
    found = moved.sample(query).displacement[:, 0, 2]
    # 0.1 %: counts are whole numbers, and the record has ends.
    np.testing.assert_allclose(found, 1e-6 * np.sin(TAU * 10 * (query + 12.0)), atol=1e-9)
    assert any("displacement in m, as SAC has it" in note for note in moved.notes)


def test_one_file_holds_several_channels_and_epochs(counts: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.pz"
    old = sacpz(1e7, **NAMES, START="2000-01-01T00:00:00", END="2026-01-05T00:00:00")
    new = sacpz(2e7, **NAMES, START="2026-01-05T00:00:00", END="2099-12-31T23:59:59")
    other = sacpz(4e7, **(NAMES | {"CHANNEL": "HHN"}))
    path.write_text(old + new + other)
    _, expected = signal.freqs_zpk(np.zeros(3), POLES, 2e7, [TAU * 10])
    assert response_at(counts, path)[0] == pytest.approx(expected[0], rel=1e-6)
    path.write_text(new + new)
    with pytest.raises(ValueError, match=r"more than one response of XX\.ONE\.\.HHZ at 2026.*hold XX\.ONE\.\.HHZ"):
        response_at(counts, path)
    path.write_text(old + other)
    with pytest.raises(ValueError, match=r"hold no response of XX\.ONE\.\.HHZ at 2026.*XX\.ONE\.\.HHN"):
        response_at(counts, path)


def test_constant_and_its_factors_are_compared(counts: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.pz"
    path.write_text(sacpz(3e7, **NAMES, A0="1.0e0", SENSITIVITY="9.0e8 (M/S)"))
    with pytest.raises(ValueError, match=r"9e\+08 counts per 'm', its stages make 3e\+07 .*A0·SENSITIVITY"):
        response_at(counts, path)
    whole, _, _ = response_at(counts, path, response="stages")
    assert response_at(counts, path, response="sensitivity")[0] == pytest.approx(30 * whole)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ZEROS 1\nPOLES 2\n-1 0\nCONSTANT 1\n", "POLES of XX.ONE..HHZ: 2 are announced, 1 follow"),
        ("ZEROS 1\n0 0\n0 0\nPOLES 1\n-1 0\n", "ZEROS of XX.ONE..HHZ: 1 are announced, 2 follow"),
        ("ZEROS 1\nPOLES 1\n-1 x\n", "line 3 of poles and zeros, '-1 x'"),
        ("ZEROS 1\nPOLES 1\n-1 nan\n", "line 3 .*not finite"),
        ("ZEROS 1\nPOLES 99999999\n", "line 2 .*1000 roots are allowed"),
        ("* INPUT UNIT : PA\nZEROS 0\nPOLES 0\nCONSTANT 1\n", "senses 'PA'"),
        ("* OUTPUT UNIT : V\nZEROS 0\nPOLES 0\nCONSTANT 1\n", "ends in 'V', not in counts"),
    ],
)
def test_poles_and_zeros_that_are_not_whole_are_refused(counts: Path, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.pz").write_text(text)
    with pytest.raises(ValueError, match=message):
        response_at(counts, tmp_path / "a.pz")


def test_what_evalresp_prints_of_a_failure_is_in_the_refusal(
    counts: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    made = two_stages()
    made.response_stages[1].stage_gain = None
    with pytest.raises(ValueError, match=r"response of XX\.ONE\.\.HHZ cannot be evaluated: ") as caught:
        response_at(counts, metadata(tmp_path / "a.xml", made))
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_evalresp_comes_without_what_draws_spectra_and_that_is_still_to_be_had() -> None:
    code = (
        "import sys; from ehamj.ground.records import RecordGround; from ehamj.records.seismic import EXAMPLE; "
        "RecordGround(kind='record', file=EXAMPLE).read(); assert 'matplotlib' not in sys.modules; "
        "from obspy.signal import PPSD; import obspy.signal.spectral_estimation as whole; assert PPSD is whole.PPSD"
    )
    subprocess.run([sys.executable, "-c", code], check=True)

"""Files of frequency responses: values in ehamj's units, how well they are known, and what is refused by its key."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff

from ehamj.errors import InputError
from ehamj.measured.measured import MeasuredResponses
from ehamj.measured.responses import ResponseChoices, read_responses
from ehamj.measured.responses.variance import LEAST, variance
from ehamj.measured.settings import MeasuredComponent
from ehamj.plant.mounts import MOUNTS

HERTZ = np.arange(0.0, 100.5, 0.5)
TURN = 2j * np.pi * HERTZ
MOBILITY = TURN**2 / (4000.0 * ((2 * np.pi * 30.0) ** 2 + 0.05 * 2 * np.pi * 30.0 * TURN + TURN**2))
"""Acceleration over force of a mass on a spring [m/s²/N]."""
COHERENCE = np.clip(0.99 - 0.3 * np.exp(-(((HERTZ - 60.0) / 5.0) ** 2)), 0.0, 1.0)
HIT: dict[str, Any] = {"force": {"point": [0.5, 0.4, 0.9]}}
FELT: dict[str, Any] = {"channel": "foot_acceleration front-left z"}


def read(path: Path, measurement: dict[str, Any], **said: Any) -> MeasuredResponses:
    parts = {name: MeasuredComponent.model_validate(one) for name, one in measurement.items()}
    return read_responses(path, parts, MOUNTS, ResponseChoices.model_validate(said), "test.0")


def head(kind: int, values: np.ndarray, **more: Any) -> dict[str, Any]:
    complex_one = np.iscomplexobj(values)
    return {
        "type": 58, "func_type": kind, "rsp_node": 12, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3, "data": values,
        "x": HERTZ, "id1": "a", "rsp_ent_name": "NONE", "ref_ent_name": "NONE", "binary": 0, "num_pts": HERTZ.size,
        "ord_data_type": 6 if complex_one else 4, "abscissa_spacing": 1, "abscissa_min": 0.0, "abscissa_inc": 0.5,
        "abscissa_spec_data_type": 18, "abscissa_axis_units_lab": "Hz", "ordinate_axis_units_lab": "m/s^2",
        "orddenom_axis_units_lab": "N", "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13,
        "z_axis_spec_data_type": 0, **more,
    }  # fmt: skip


def universal(path: Path, *heads: dict[str, Any]) -> Path:
    pyuff.UFF(str(path)).write_sets(list(heads), "overwrite")
    return path


def test_a_universal_file_gives_responses_and_their_coherence(tmp_path: Path) -> None:
    """Each pair by its places; a negative direction turns the sign, and units are the labels'."""
    other = head(4, MOBILITY / 9.80665 * 1e3, rsp_node=7, rsp_dir=-3, ordinate_axis_units_lab="g",
                 orddenom_axis_units_lab="kN")  # fmt: skip
    path = universal(
        tmp_path / "a.uff", head(4, MOBILITY), head(6, COHERENCE), other, head(4, 3.0 * MOBILITY, ref_dir=1)
    )
    table = {"12:+Z": FELT, "hit": HIT | {"component": "1:+Z"}}
    table["7:-Z"] = {"channel": "foot_acceleration rear-left z"}
    found = read(path, table, averages=20.0, deviation=0.02)
    assert (found.inputs, found.input_units) == (("force hit",), ("N",))
    assert found.output_units == ("m/s²", "m/s²")
    np.testing.assert_allclose(found.frequency, HERTZ[1:])
    np.testing.assert_allclose(found.response[:, 0, 0], MOBILITY[1:], rtol=1e-5)
    np.testing.assert_allclose(found.response[:, 1, 0], -MOBILITY[1:], rtol=1e-5)
    np.testing.assert_allclose(found.coherence[:, 0, 0], COHERENCE[1:], rtol=1e-5)
    exact = np.abs(MOBILITY) ** 2 * (1.0 - COHERENCE) / COHERENCE / 20.0
    np.testing.assert_allclose(found.variance[:, 0, 0], exact[1:], rtol=1e-3)
    assert np.isnan(found.coherence[:, 1, 0]).all()
    np.testing.assert_allclose(found.variance[:, 1, 0], (0.02 * np.abs(MOBILITY[1:])) ** 2, rtol=1e-4)
    assert found.places[0] is not None
    assert found.places[0].point == (0.5, 0.4, 0.9)


def test_spectra_beside_a_response_tell_its_coherence(tmp_path: Path) -> None:
    x, y = np.full(HERTZ.size, 4.0), 9.0 + HERTZ / 10.0
    cross = np.sqrt(COHERENCE * x * y) * np.exp(0.3j * HERTZ)
    autos = [head(2, x, rsp_node=1), head(2, y, ref_node=12)]
    path = universal(tmp_path / "a.unv", head(4, MOBILITY), head(3, cross), *autos)
    found = read(path, {"12:+Z": FELT, "1:+Z": HIT}, averages=10.0)
    np.testing.assert_allclose(found.coherence[:, 0, 0], COHERENCE[1:], rtol=1e-4)


def written(path: Path, heads: str, *columns: np.ndarray) -> Path:
    rows = "\n".join(",".join(f"{one:.9g}" for one in row) for row in np.column_stack(columns)[1:])
    path.write_text(f"{heads}\n{rows}\n")
    return path


PARTS = (MOBILITY.real, MOBILITY.imag)
SIZE, PHASE = np.abs(MOBILITY), np.unwrap(np.angle(MOBILITY))
with np.errstate(divide="ignore"):
    DECIBEL = 20.0 * np.log10(SIZE)
SI: dict[str, Any] = {"a": FELT | {"unit": "SI"}, "f": HIT | {"unit": "N"}}
BARE: dict[str, Any] = {"a": FELT, "f": HIT}
TABLES: dict[str, tuple[str, tuple[np.ndarray, ...], dict[str, Any]]] = {
    "parts": ("frequency [Hz],real [m/s^2/N],imag [m/s^2/N],coherence", (HERTZ, *PARTS, COHERENCE), BARE),
    "parts in g over kN": ("f [Hz],re [g/kN],im [g/kN]", (HERTZ, *(1e3 / 9.80665 * p for p in PARTS)), BARE),
    "rad/s": ("frequency [rad/s],Re,Im", (2 * np.pi * HERTZ, *PARTS), SI),
    "decibels": ("Frequency (Hz),Magnitude (dB),Phase (deg)", (HERTZ, DECIBEL, np.rad2deg(PHASE)), SI),
    "radians": ("freq [Hz],abs [m/s^2/N],phase [rad],coh", (HERTZ, SIZE, PHASE, COHERENCE), BARE),
    "user's units": ("freq,re,im", (HERTZ, *(10.0 * p for p in PARTS)),
                     {"a": FELT | {"unit": "cm/s^2"}, "f": HIT | {"unit": "N", "scale": 0.1}}),
}  # fmt: skip


@pytest.mark.parametrize("what", TABLES)
def test_a_table_is_read_however_it_is_written(what: str, tmp_path: Path) -> None:
    heads, columns, table = TABLES[what]
    found = read(written(tmp_path / "a.csv", heads, *columns), table, averages=8.0, deviation=0.1)
    np.testing.assert_allclose(found.frequency, HERTZ[1:], rtol=1e-8)
    scale = 10.0 * 1e-2 / 0.1 if what == "user's units" else 1.0
    np.testing.assert_allclose(found.response[:, 0, 0], scale * MOBILITY[1:], rtol=1e-6)
    if "coh" in heads:
        np.testing.assert_allclose(found.variance[:, 0, 0], variance(MOBILITY, COHERENCE, 8.0)[0][1:], rtol=1e-5)


def test_pairs_say_which_columns_are_what(tmp_path: Path) -> None:
    heads = "f,z r,z i,p r,p i,c"
    path = written(tmp_path / "a.csv", heads, HERTZ, *PARTS, *(2.0 * part for part in PARTS), COHERENCE)
    table = SI | {"p": {"channel": "foot_acceleration rear-left z", "unit": "SI"}}
    pairs = [{"output": "a", "input": "f", "real": "z r", "imaginary": "3"},
             {"output": "p", "input": "f", "real": "p r", "imaginary": "p i", "coherence": "c"}]  # fmt: skip
    found = read(path, table, pair=pairs, averages=4.0, deviation=0.1)
    np.testing.assert_allclose(found.response[:, 1, 0], 2.0 * found.response[:, 0, 0], rtol=1e-6)
    np.testing.assert_allclose(found.response[:, 0, 0], MOBILITY[1:], rtol=1e-6)


@pytest.mark.parametrize("form", ["RI", "MA", "DB"])
def test_a_touchstone_like_file_is_a_container(form: str, tmp_path: Path) -> None:
    degrees = np.rad2deg(PHASE)
    parts = {"RI": PARTS, "MA": (SIZE, degrees), "DB": (DECIBEL, degrees)}[form]
    lines = ["! made up", f"# kHz S {form} R 50"]
    for hertz, first, second in zip(HERTZ[1:], *(part[1:] for part in parts), strict=True):
        lines += [f"{hertz / 1e3:.9g} {first:.9g} {second:.9g} 1 0", f" {first:.9g} {second:.9g} 2 0 ! goes on"]
    path = tmp_path / "a.s2p"
    path.write_text("\n".join(lines) + "\n")
    found = read(path, SI, pair=[{"output": "a", "input": "f", "number": 3}], deviation=0.05)
    np.testing.assert_allclose(found.response[:, 0, 0], MOBILITY[1:], rtol=1e-5)
    np.testing.assert_allclose(found.frequency, HERTZ[1:])
    with pytest.raises(InputError, match=r"test\.0\.pair is missing: 'a\.s2p' has 4 complex numbers in a row"):
        read(path, SI, deviation=0.05)
    with pytest.raises(InputError, match=r"test\.0\.pair\.0\.number = 5: 'a\.s2p' has 4"):
        read(path, SI, pair=[{"output": "a", "input": "f", "number": 5}], deviation=0.05)


def test_the_variance_is_that_of_many_measurements() -> None:
    """H1 and ordinary coherence of n averages, 4000 times; the coherence of n averages itself is too large by 1/n."""
    random, n, draws = np.random.default_rng(3), 40, 4000

    def normal(*shape: int) -> np.ndarray:
        return random.standard_normal(shape) + 1j * random.standard_normal(shape)

    x, noise = normal(draws, n), 0.7 * normal(draws, n)
    y = (2.0 - 1.0j) * x + noise
    xx, yy, yx = (np.abs(x) ** 2).sum(1), (np.abs(y) ** 2).sum(1), (y * x.conj()).sum(1)
    h1, coherence = yx / xx, np.abs(yx) ** 2 / xx / yy
    stated, raised = variance(h1, coherence, float(n))
    assert not raised
    assert np.mean(np.abs(h1 - (2.0 - 1.0j)) ** 2) / np.mean(stated) == pytest.approx(1.0, abs=0.06)
    np.testing.assert_allclose(variance(np.array([3.0 + 4.0j]), np.array([1.0]), 8.0)[0], (5.0 * LEAST) ** 2)


WRONG: dict[str, tuple[str, dict[str, Any], dict[str, Any], tuple[str, ...]]] = {
    "no averages": ("f,re,im,coh", SI, {}, ("test.0.averages is missing", "a over f", "deviation")),
    "no deviation": ("f,re,im,x", SI, {"averages": 4.0}, ("test.0.deviation is missing",)),
    "no unit": ("f,re,im,coh", BARE, {"averages": 4.0}, ("test.0.measurement.a.unit is missing", "'SI'")),
    "another unit": (
        "f,re [bar/V],im [bar/V],coh", BARE, {"averages": 4.0}, ("measurement.a: a over f is in bar/V", "(m/s²)/(N)")),
    "two units": (
        "f,re [g/N],im [g/N],coh", SI, {"averages": 4.0}, ("measurement.a.unit = 'SI'", "g/N", "leave unit out")),
    "phase": ("f,mag,phase,coh", SI, {"averages": 4.0}, ("test.0.phase_unit is missing", "deg or rad")),
    "which columns": ("f,a,b,c", SI, {"averages": 4.0}, ("test.0.pair is missing", "'a'")),
    "frequencies": ("x,re,im,coh", SI, {"averages": 4.0}, ("hold frequencies", "test.0.table.columns")),
    "coherence": ("f,coh,im,re", SI, {"averages": 4.0}, ("test.0.file: the coherence of a over f", "0 to 1")),
    "no input": ("f,re,im,coh", {"a": FELT}, {"averages": 4.0}, ("test.0.measurement", "only output")),
    "pair of none": (
        "f,re,im,coh", SI, {"averages": 4.0, "pair": [{"output": "b", "input": "f", "real": "re", "imaginary": "im"}]},
        ("test.0.pair.0.output = 'b'", "a")),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_what_is_not_told_or_contradicts_is_refused_by_its_key(what: str, tmp_path: Path) -> None:
    heads, table, said, told = WRONG[what]
    path = written(tmp_path / "a.csv", heads, HERTZ, *(1e4 * part for part in PARTS), COHERENCE)
    with pytest.raises(InputError) as error:
        read(path, table, **said)
    for part in told:
        assert part in str(error.value)
    assert "ground." not in str(error.value)
    assert "\n" not in str(error.value)


def test_a_universal_file_without_the_pair_lists_what_it_holds(tmp_path: Path) -> None:
    path = universal(tmp_path / "a.uff", head(4, MOBILITY))
    with pytest.raises(InputError, match=r"test\.0\.measurement\.\"13:\+Z\": .* it holds 12:\+Z over 1:\+Z"):
        read(path, {"13:+Z": FELT, "1:+Z": HIT}, deviation=0.1)
    with pytest.raises(InputError, match=r"test\.0\.pair is of use with tables only"):
        read(path, {"12:+Z": FELT, "1:+Z": HIT}, pair=[{"output": "12:+Z", "input": "1:+Z"}])
    universal(tmp_path / "b.uff", head(6, COHERENCE))
    with pytest.raises(InputError, match=r"test\.0\.file = 'b\.uff' holds no frequency response"):
        read(tmp_path / "b.uff", {"12:+Z": FELT, "1:+Z": HIT})

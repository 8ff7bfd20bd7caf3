"""Target spectra: integrals over bands, straight lines between points, refusals outside, files, Peterson's models."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.estimate.bands import Band, band_numbers, bands
from ehamj.estimate.reading import band_rms
from ehamj.ground import Motion
from ehamj.ground.spectra import from_psd, from_third_octaves
from ehamj.ground.targets import FileTarget, PetersonTarget
from ehamj.scenario.load import parse_scenario

NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
ORDERS = {"displacement": -1, "velocity": 0, "acceleration": 1}


def integral(density: Any, low: float, high: float) -> float:
    """Integral over a frequency range, on a logarithmic axis, in two halves: at the centre the slope changes."""
    middle = np.sqrt(low * high)
    total = 0.0
    for a, b in ((low, middle), (middle, high)):
        u = 0.5 * (np.log(a) + np.log(b) + NODES * np.log(b / a))
        total += 0.5 * np.log(b / a) * float(WEIGHTS @ (density(np.exp(u)) * np.exp(u)))
    return total


# --- shapes -------------------------------------------------------------------------------------------------------

levels = st.lists(st.floats(-9.0, -3.0).map(lambda power: 10.0**power), min_size=1, max_size=8)


@given(levels, st.integers(-30, -10), st.sampled_from(sorted(ORDERS)))
def test_every_band_of_a_third_octave_target_has_its_level(found: list[float], first: int, quantity: Any) -> None:
    numbers = np.arange(first, first + len(found))
    spectrum = from_third_octaves(numbers, np.array(found), quantity)
    for number, level in zip(numbers, found, strict=True):
        # Inside by 1e-12: the very edges belong to both bands.
        low, high = (edge * (1 + way * 1e-12) for edge, way in zip(Band(number).edges, (1, -1), strict=True))
        power = integral(lambda f: spectrum.density(f) * (2 * np.pi * f) ** (2 * ORDERS[quantity]), low, high)
        # Six decades within a band are the steepest: Gauss of 20 points holds them to 1e-9.
        assert power == pytest.approx(level**2, rel=1e-8)


def test_bands_between_two_that_are_given_lie_on_the_line_between_them() -> None:
    spectrum = from_third_octaves(np.array([-20.0, -16.0]), np.array([1e-6, 16e-6]), "velocity")
    power = integral(spectrum.density, *Band(-18).edges)
    assert np.sqrt(power) == pytest.approx(4e-6, rel=1e-9)


@given(st.floats(0.1, 10.0), st.floats(1.1, 20.0), st.floats(1e-14, 1e-8), st.floats(1e-14, 1e-8))
def test_a_psd_is_straight_on_log_log_axes_in_its_own_quantity(f: float, ratio: float, one: float, two: float) -> None:
    for quantity, order in ORDERS.items():
        spectrum = from_psd(np.array([f, f * ratio]), np.array([one, two]), quantity)  # type: ignore[arg-type]
        middle = np.array([f * np.sqrt(ratio)])
        own = spectrum.density(middle) * (2 * np.pi * middle) ** (2 * order)
        assert own[0] == pytest.approx(np.sqrt(one * two), rel=1e-10)


@pytest.mark.parametrize("frequency", [0.999, 20.001, 0.0])
def test_outside_of_what_is_given_nothing_is_held(frequency: float) -> None:
    spectrum = from_psd(np.array([1.0, 20.0]), np.array([1e-12, 1e-12]), "velocity")
    with pytest.raises(ValueError, match=f"known from 1 to 20 Hz, not at {frequency:g} Hz"):
        spectrum.density(np.array([5.0, frequency]))


@pytest.mark.parametrize(
    ("model", "period", "decibel"),
    [("low", 1.0, -166.4), ("low", 0.25, -166.7), ("high", 1.0, -116.85), ("high", 5.0, -74.66 - 32.95 * np.log10(5))],
)
def test_petersons_models_have_the_values_of_his_tables(model: Any, period: float, decibel: float) -> None:
    spectrum = PetersonTarget(kind="peterson", model=model).spectra(("z",))["z"]
    f = np.array([1.0 / period])
    found = 10 * np.log10(spectrum.density(f) * (2 * np.pi * f) ** 2)[0]
    # ObsPy tabulates 1001 periods, between which corners of the models are cut: 0.05 dB.
    assert found == pytest.approx(decibel, abs=0.05)
    assert (spectrum.low, spectrum.high) == (1e-5, 10.0)


@given(st.integers(-33, 20))
def test_nominal_centres_are_recognised(number: int) -> None:
    assert band_numbers((float(Band(number).name), Band(number + 1).centre)).tolist() == [number, number + 1]


# --- floors that are shaped ---------------------------------------------------------------------------------------

STEEP = {"kind": "third-octave", "bands": [1.0, 1.25, 2.5, 8.0, 16.0, 20.0, 31.5, 80.0]}
STEEP["levels"] = [1e-6, 5e-6, 20e-6, 20e-6, 2e-6, 40e-6, 10e-6, 3e-6]
ACCELERATION = {"kind": "psd", "quantity": "acceleration", "frequencies": [0.8, 5.0, 30.0, 100.0]}
ACCELERATION["density"] = [1e-9, 1e-7, 1e-6, 3e-8]
TARGETS = {"steep": STEEP, "acceleration": ACCELERATION}
COHERENT = {"wave": {"speed": 200.0, "direction": 30.0}, "coherence": {}}
MINUTE = 60.0
BANDS = bands(1.0, 80.0)


def floor(target: dict[str, Any], seed: int = 0, duration: float = MINUTE, **ground: Any) -> Motion:
    table = {"kind": "shaped", "target": target, "fade_in": 0.0, **ground}
    return parse_scenario({"duration": duration, "seed": seed, "ground": table}).motion()


def wanted(name: str) -> np.ndarray:
    """Third-octave velocity of a target, integrated from its definition alone."""
    target = TARGETS[name]
    if name == "steep":
        numbers = np.rint(10 * np.log10(np.array(target["bands"]) / 1000.0))
        found = np.interp([band.index for band in BANDS], numbers, np.log(target["levels"]))
        return np.exp(found)
    f = np.geomspace(0.8, 100.0, 400_001)
    psd = np.exp(np.interp(np.log(f), np.log(target["frequencies"]), np.log(target["density"]))) / (2 * np.pi * f) ** 2
    inside = [(f >= band.edges[0]) & (f <= band.edges[1]) for band in BANDS]
    return np.array([np.sqrt(np.trapezoid(psd[part], f[part])) for part in inside])


@pytest.mark.parametrize("options", [{}, COHERENT], ids=["slab", "coherent"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_minute_as_a_criterion_reads_it_is_within_a_decibel_of_its_target(options: dict[str, Any], seed: int) -> None:
    velocity = floor(ACCELERATION, seed, **options).sample(np.arange(60_000) / 1000.0).velocity[:, :, 2]
    read = band_rms(velocity, 1000.0, BANDS)  # one Hann window over the run
    assert np.abs(20 * np.log10(read / wanted("acceleration")[:, None])).max() <= 1.0


@pytest.mark.parametrize("options", [{}, COHERENT], ids=["slab", "coherent"])
@pytest.mark.parametrize("name", TARGETS)
def test_a_minute_has_its_target_at_every_mount(name: str, options: dict[str, Any]) -> None:
    """Read over the run, which is the floor's period, so without a window and its leakage from band to band."""
    velocity = floor(TARGETS[name], **options).sample(np.arange(60_000) / 1000.0).velocity[:, :, 2]
    power = 2 * np.abs(np.fft.rfft(velocity, axis=0)) ** 2 / 60_000**2
    number = np.rint(10 * np.log10(np.maximum(np.arange(30_001) / MINUTE, 1e-9) / 1000.0))
    found = np.array([np.sqrt(power[number == band.index].sum(axis=0)) for band in BANDS])
    # Lines count by where they lie, whole: half of one at an edge, of the 14 in the lowest band, is 0.15 dB.
    assert np.abs(20 * np.log10(found / wanted(name)[:, None])).max() <= 0.15


def test_scale_and_first_and_last_cut_and_stretch() -> None:
    times = np.arange(10_000) / 1000.0
    whole, cut, double = (
        floor(ACCELERATION, duration=10.0, **options).sample(times).velocity[:, 0, 2]
        for options in ({}, {"first": 10.0, "last": 20.0}, {"scale": 2.0})
    )
    np.testing.assert_allclose(double, 2.0 * whole, rtol=1e-12, atol=1e-18)
    power = np.abs(np.fft.rfft(cut)) ** 2
    frequency = np.arange(power.size) / 10.0
    inside = (frequency > 9.9) & (frequency < 20.1)
    # Splines between samples leave 1e-10 of the power elsewhere.
    assert power[~inside].sum() < 1e-8 * power.sum()


def test_a_shaped_floor_says_where_it_ends() -> None:
    motion = floor({"kind": "peterson"}, duration=20.0)
    assert motion.usable_to == 10.0
    assert any("to 10 Hz: bands from 10 Hz on are undecided" in note for note in motion.notes)


# --- files --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "quantity", "size"),
    [
        ("(m/s)^2/Hz", "velocity", 1.0),
        ("(µm/s)²/Hz", "velocity", 1e-12),
        ("g^2/Hz", "acceleration", 9.80665**2),
        ("(mm/s2)**2/Hz", "acceleration", 1e-6),
        ("m^2/Hz", "displacement", 1.0),
    ],
)
def test_a_psd_file_is_the_psd_target(tmp_path: Path, unit: str, quantity: Any, size: float) -> None:
    (tmp_path / "a.csv").write_text(f"frequency [Hz], level [{unit}]\n1, 1e-3\n5, 2e-3\n20, 1e-4\n", encoding="utf-8")
    found = FileTarget(kind="file", file=str(tmp_path / "a.csv")).spectra(("z",))["z"]
    same = from_psd(np.array([1.0, 5.0, 20.0]), size * np.array([1e-3, 2e-3, 1e-4]), quantity)
    f = np.geomspace(1.0, 20.0, 50)
    np.testing.assert_allclose(found.density(f), same.density(f), rtol=1e-12)


def test_a_file_of_roots_and_columns_per_axis(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "frequency [Hz]; x [m/s/sqrt(Hz)]; z [(m/s)^2/Hz]\n1; 1e-6; 4e-12\n9; 1e-6; 4e-12\n"
    )
    found = FileTarget(kind="file", file=str(tmp_path / "a.csv")).spectra(("x", "z"))
    f = np.array([3.0])
    assert found["x"].density(f)[0] == pytest.approx(1e-12)
    assert found["z"].density(f)[0] == pytest.approx(4e-12)


def test_a_scenario_finds_its_file_beside_it_and_runs_again(tmp_path: Path) -> None:
    from ehamj.scenario.load import load_scenario

    (tmp_path / "floor.csv").write_text("band [Hz], level [um/s]\n8, 10\n10, 20\n12.5, 10\n")
    table = '[ground]\nkind = "shaped"\n[ground.target]\nkind = "file"\nfile = "floor.csv"\n'
    (tmp_path / "a.toml").write_text(table)
    scenario = load_scenario(tmp_path / "a.toml")
    (tmp_path / "b.toml").write_text(scenario.to_toml())
    times = np.linspace(0.0, 9.0, 200)
    one, other = (s.motion().sample(times) for s in (scenario, load_scenario(tmp_path / "b.toml")))
    np.testing.assert_array_equal(one, other)


FILES = {
    "first column": (
        "hertz [Hz], z [um/s]\n8, 1\n10, 1\n",
        r"first column must be 'band \[Hz\]' or 'frequency \[Hz\]'",
    ),
    "unit of levels": ("band [Hz], z [lb/s]\n8, 1\n10, 1\n", r"column 'z': 'lb/s' is not a unit that is known"),
    "unit of psd": ("frequency [Hz], z [um/s]\n8, 1\n9, 1\n", r"column 'z': 'um/s' is not \(U\)\^2/Hz"),
    "no band": ("band [Hz], z [um/s]\n8, 1\n9, 1\n", r"bands: 9 Hz is not the centre of a third-octave band"),
    "falling": ("frequency [Hz], z [m^2/Hz]\n8, 1\n7, 1\n", r"frequency must rise from row to row"),
    "zero": ("frequency [Hz], z [m^2/Hz]\n8, 1\n9, 0\n", r"every value must be positive and finite"),
    "nan": ("frequency [Hz], z [m^2/Hz]\n8, 1\n9, nan\n", r"column 'z' in line 3 is empty; it must be a number"),
    "one row": ("frequency [Hz], z [m^2/Hz]\n8, 1\n", r"must rise from row to row, in at least 2 rows"),
    "other axis": ("band [Hz], x [um/s]\n8, 1\n10, 1\n", r"it has 'x' only; set ground\.axes = \['x'\]"),
    "axis missing": (
        "band [Hz], x [um/s], y [um/s]\n8, 1, 1\n10, 1, 1\n",
        r"no column 'z' for ground\.axes; it has x, y",
    ),
    "cell": ("band [Hz], z [um/s]\n8, 1\n10, loud\n", r"line 3 holds 'loud' in column 'z', which is not a number"),
}


@pytest.mark.parametrize("fault", FILES)
def test_faults_of_files_are_named(tmp_path: Path, fault: str) -> None:
    content, message = FILES[fault]
    (tmp_path / "a.csv").write_text(content)
    target = {"kind": "file", "file": str(tmp_path / "a.csv")}
    with pytest.raises(InputError, match=rf"^ground\.target\.file = 'a\.csv': .*{message}"):
        floor(target)


@given(st.text(max_size=200))
def test_any_text_is_a_target_or_refused_in_one_line(tmp_path_factory: Any, text: str) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz.csv"
    path.write_text(text, encoding="utf-8", errors="replace")
    try:
        FileTarget(kind="file", file=str(path)).spectra(("z",))
    except ValueError as error:
        assert str(error).startswith("ground.target.file")  # noqa: PT017


# --- what a user writes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"target": {"kind": "peterson"}, "last": 20.0}, r"ground\.last = 20 Hz must lie from 1e-05 to 10 Hz"),
        ({"target": STEEP, "first": 0.5}, r"ground\.first = 0\.5 Hz must lie from 0\.8912\d* to 89\.12\d* Hz"),
        ({"target": STEEP, "first": 20.0, "last": 10.0}, r"ground\.first = 20 Hz must be below ground\.last = 10 Hz"),
        ({"target": {"kind": "psd", "frequencies": [1.0, 2.0], "density": [1.0]}}, r"ground\.target: density has 1 v"),
        (
            {"target": {"kind": "psd", "frequencies": [2.0, 1.0], "density": [1.0, 1.0]}},
            r"ground\.target: frequencies must rise; 1 Hz does not",
        ),
        (
            {"target": {"kind": "psd", "frequencies": [1.0, 2.0], "density": [1.0, 0.0]}},
            r"ground\.target\.density\.1 = 0\.0: must be greater than 0",
        ),
        (
            {"target": {"kind": "third-octave", "bands": [9.0], "levels": [1e-6]}},
            r"ground\.target\.bands: 9 Hz is not the centre of a third-octave band",
        ),
        (
            {"target": {"kind": "third-octave", "bands": [8.0, 8.0], "levels": [1e-6, 1e-6]}},
            r"ground\.target: bands must rise; 8 Hz does not",
        ),
        ({"target": {"kind": "noise"}}, r"ground\.target\.kind = 'noise': must be one of 'third-octave', 'psd', 'pet"),
        ({}, r"ground\.target: is missing"),
        ({"target": STEEP, "scale": 0.0}, r"ground\.scale = 0\.0: must be greater than 0"),
    ],
)
def test_bad_input_is_named_with_its_value_and_what_is_allowed(ground: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": {"kind": "shaped", **ground}}).motion()

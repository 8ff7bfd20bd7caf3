"""The reproduction of the paper against physics.md, the oracle's closed forms, and itself read back from its record."""

import csv
import json
import math
import re
import struct
from pathlib import Path

import pytest
from oracles import linear

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION, RECOMMENDED
from ehamj.paper.actuator import FAST_VALVE
from ehamj.paper.cases import CASES, PaperStudy
from ehamj.paper.figures import FIGURES, figure, root_locus
from ehamj.paper.loop import PositionLoop
from ehamj.paper.page import write_paper
from ehamj.paper.reproduction import AGREES, FAILS, GIVEN, ROUNDED, Reproduction, reproduce

TABLE = linear.PaperActuator()
"""Table I, typed in once more by the oracle."""


@pytest.fixture(scope="module")
def paper() -> Reproduction:
    return reproduce()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper") / "new"
    write_paper(folder, reproduce())
    return folder


def scaled(**factors: float) -> linear.PaperActuator:
    """Table I with some values multiplied."""
    return linear.PaperActuator(**{name: factor * getattr(TABLE, name) for name, factor in factors.items()})


ORACLES = {
    "initial": TABLE,
    "volume_double": scaled(V_t=2),
    "volume_half": scaled(V_t=0.5),
    "area_double": scaled(A_p=2),
    "area_half": scaled(A_p=0.5),
    "flow_gain_double": scaled(K_Q=2),
    "flow_gain_half": scaled(K_Q=0.5),
    "flow_pressure_double": scaled(K_C=2),
    "flow_pressure_half": scaled(K_C=0.5),
    "recommended": scaled(V_t=0.5, A_p=2, K_C=2),
}
NUMBERS = ("omega_h_hz", "delta_h", "gain_margin_db", "phase_crossover_hz")


# --- cases ---------------------------------------------------------------------------------------------------------


def test_the_ten_cases_are_there_with_eight_numbers_each(paper: Reproduction) -> None:
    cases = paper.to_dict()["cases"]
    assert list(cases) == list(ORACLES) == list(CASES)
    for case in cases.values():
        assert {f"{name}{suffix}" for name in NUMBERS for suffix in ("", "_eq8")} <= set(case)


@pytest.mark.parametrize("name", ORACLES)
def test_cases_are_the_oracles(paper: Reproduction, name: str) -> None:
    numbers, p = paper.cases[name].numbers(), ORACLES[name]
    for suffix, exact in (("", True), ("_eq8", False)):
        assert numbers[f"omega_h_hz{suffix}"] == pytest.approx(linear.omega_h(p) / (2 * math.pi), rel=1e-13)
        assert numbers[f"delta_h{suffix}"] == pytest.approx(linear.delta_h(p), rel=1e-13)
        margins = (numbers[f"gain_margin_db{suffix}"], numbers[f"phase_crossover_hz{suffix}"])
        assert margins == pytest.approx(linear.gain_margin(p, exact), abs=1e-9)  # the oracle's brackets: 1e-10 Hz


PRINTED = {  # physics.md, section 1: half a unit of the last digit is what a printed number leaves open
    ("initial", "omega_h_hz"): (256.2, 0.05),
    ("initial", "delta_h"): (0.213, 0.0005),
    ("volume_double", "omega_h_hz"): (181.1, 0.05),
    ("volume_half", "omega_h_hz"): (362.3, 0.05),
    ("volume_double", "delta_h"): (0.151, 0.0005),
    ("volume_half", "delta_h"): (0.301, 0.0005),
    ("area_double", "omega_h_hz"): (512.3, 0.05),
    ("area_half", "omega_h_hz"): (128.1, 0.05),
    ("area_double", "delta_h"): (0.107, 0.0005),
    ("area_half", "delta_h"): (0.426, 0.0005),
    ("recommended", "omega_h_hz"): (724.5, 0.05),
    ("recommended", "delta_h"): (0.301, 0.0005),
    ("initial", "gain_margin_db_eq8"): (135.2, 0.05),
    ("initial", "phase_crossover_hz_eq8"): (178.6, 0.05),
    ("initial", "gain_margin_db"): (135.8, 0.05),
    ("initial", "phase_crossover_hz"): (183.5, 0.05),
    ("recommended", "gain_margin_db_eq8"): (147.9, 0.05),
    ("recommended", "phase_crossover_hz_eq8"): (221.5, 0.05),
    ("recommended", "gain_margin_db"): (147.9, 0.05),
    ("recommended", "phase_crossover_hz"): (221.9, 0.05),
}


@pytest.mark.parametrize(("case", "number"), PRINTED, ids=" ".join)
def test_numbers_of_physics_md(paper: Reproduction, case: str, number: str) -> None:
    value, half_unit = PRINTED[case, number]
    assert paper.to_dict()["cases"][case][number] == pytest.approx(value, abs=half_unit)


def test_the_other_reading_gives_the_papers_margins(paper: Reproduction) -> None:
    for name, expected in (("initial", (115.7, 187.1)), ("recommended", (128.1, 229.4))):
        numbers = paper.variants[f"{name}_reading"].numbers()
        assert (numbers["gain_margin_db"], numbers["phase_crossover_hz"]) == pytest.approx(expected, abs=0.05)
    assert PaperStudy().reading()["flow_gain"] == pytest.approx(1.94e-5, rel=1e-14)


def test_the_recommended_design_is_the_preset_and_the_faster_valve_is_faster(paper: Reproduction) -> None:
    study = PaperStudy()
    design = study.design("recommended")
    for name in ("chamber_volume", "piston_area", "flow_pressure", "valve_frequency", "flow_gain"):
        assert getattr(design, name) == getattr(RECOMMENDED, name)
    assert study.design("recommended_fast_valve").valve_frequency == FAST_VALVE == pytest.approx(2 * math.pi * 400)
    slow, fast = paper.cases["recommended"].merits, paper.variants["recommended_fast_valve"].merits
    assert fast.bandwidth_hz > 1.4 * slow.bandwidth_hz
    assert study.design("initial") == FIRST_GENERATION


# --- table and claims ----------------------------------------------------------------------------------------------


def test_every_number_of_the_paper_is_in_the_table(paper: Reproduction) -> None:
    stated = [row.stated for row in paper.table]
    for number in ("257 Hz", "182 Hz", "363 Hz", "513 Hz", "128 Hz", "726 Hz", "250 Hz", "100 Hz", "400 Hz", "90 deg"):
        assert number in stated
    assert stated.count("0.3") == 2
    assert stated.count("0.15") == 1
    for number in ("116 dB", "128 dB", "187 Hz", "230 Hz"):
        assert stated.count(number) == 3  # exact, eq. 8, other reading


def test_the_table_says_what_does_not_reproduce(paper: Reproduction) -> None:
    failed = [row for row in paper.table if row.verdict == FAILS]
    assert {row.name for row in failed} == {
        f"{what}, {design}"
        for what in ("gain margin", "frequency of the gain margin")
        for design in ("initial design", "recommended design")
    }
    assert {row.note for row in failed} == {"exact form", "eq. 8 corrected"}
    other = [row for row in paper.table if "ten times the loop gain and a valve of 260 Hz" in row.note]
    assert len(other) == 4
    assert all(row.verdict in (AGREES, ROUNDED) for row in other)
    assert all(row.verdict == GIVEN for row in paper.table if row.stated in ("100 Hz", "400 Hz"))


def test_deviations(paper: Reproduction) -> None:
    row = paper.table[0]
    assert (row.stated, row.computed, row.deviation) == ("257 Hz", "256.2 Hz", "−0.8 Hz (−0.3 %)")
    margin = next(row for row in paper.table if row.name == "gain margin, initial design")
    assert (margin.stated, margin.computed, margin.deviation) == ("116 dB", "135.8 dB", "+19.8 dB")
    assert margin.to_dict()["deviation"] == pytest.approx(19.8, abs=0.05)
    assert not any("−0.0 Hz (+" in row.deviation or row.deviation == "−0.0 deg" for row in paper.table)


def test_rounding_of_table_1_is_the_sum_of_slopes_times_half_units(paper: Reproduction) -> None:
    # ω_h ~ A_p (β/(V_t M))^½: half units over values, by hand.
    relative = 0.005 / 3.18 + 0.5 * (0.05 / 1.4 + 0.005 / 5.39 + 0.5 / 4056)
    low, high = paper.table[0].allowed or (0.0, 0.0)
    assert (high - low) / 2 / paper.table[0].value == pytest.approx(relative, rel=1e-3)  # first order


def test_one_frequency_gives_all_six(paper: Reproduction) -> None:
    found = next(claim.finding for claim in paper.claims if claim.statement.startswith("Hydro-mechanical"))
    low, high = map(float, re.findall(r"between (\S+) and (\S+) Hz", found)[0])
    for initial in (low + 0.005, high - 0.005):
        ratios = {257: 1.0, 182: 2**-0.5, 363: 2**0.5, 513: 2.0, 128: 0.5, 726: 8**0.5}
        assert all(round(initial * ratio) == printed for printed, ratio in ratios.items())


def test_claims_carry_the_discrepancies(paper: Reproduction) -> None:
    told = " ".join(claim.finding for claim in paper.claims)
    for words in (
        "lacks its s",
        "19.8 and 19.9 dB more: a factor of ten",
        "115.7 dB at 187.1 Hz, 128.1 dB at 229.4 Hz",
        "512 Hz and a damping ratio of 0.107",
        "+6.02 dB",
        "6.0 dB of it only say",
        "60 Hz initially, 122 Hz with the piston alone, 130 Hz with piston and chamber, 124 Hz with all three",
        "passed at 255 Hz and 252 Hz",
    ):
        assert words in told


# --- files ---------------------------------------------------------------------------------------------------------


def test_write_paper_writes_every_figure_twice(folder: Path) -> None:
    expected = {f"{name}.{kind}" for name in (*FIGURES, "root-locus") for kind in ("svg", "png")}
    assert {path.name for path in folder.iterdir()} == expected | {"table.html", "table.csv", "paper.json"}
    for name in FIGURES:
        header = (folder / f"{name}.png").read_bytes()[:24]
        width, height = struct.unpack(">II", header[16:24])
        assert width >= 1500  # print quality: 5 inches at 300 dpi
        assert height >= 1200
        assert (folder / f"{name}.svg").read_text().rstrip().endswith("</svg>")


def test_written_files_are_the_same_every_time(folder: Path, tmp_path: Path) -> None:
    write_paper(tmp_path, reproduce())
    for path in folder.iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes(), path.name


def test_record_says_what_was_computed(folder: Path, paper: Reproduction) -> None:
    record = json.loads((folder / "paper.json").read_text("utf-8"))
    assert record == json.loads(json.dumps(paper.to_dict()))
    other = PaperStudy(FIRST_GENERATION.with_values({"bulk_modulus": 1.2e9}), mass=2000.0, factor=3.0)
    study = json.loads(json.dumps(reproduce(other).to_dict()))["study"]
    assert study["actuator"]["bulk_modulus"] == {"value": 1.2e9, "unit": "Pa", "symbol": "β", "source": "given"}
    assert study["actuator"]["piston_area"]["source"] == "paper"
    assert (study["mass"], study["factor"]) == (2000.0, 3.0)


def test_csv_and_page_hold_every_row(folder: Path, paper: Reproduction) -> None:
    with (folder / "table.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["computed"]) for row in rows] == [row.value for row in paper.table]
    page = (folder / "table.html").read_text("utf-8")
    assert page.count("<tr>") == len(paper.table) + len(paper.claims) + 2
    assert page.count('class="badge fails"') == 4 * 2
    assert all(f'<figure id="figure-{name}"' in page for name in FIGURES)


def test_figures_show_both_panels_with_units(paper: Reproduction) -> None:
    for name, (_, cases) in FIGURES.items():
        drawn = figure(paper, name)
        above, below = drawn.axes
        assert above.get_ylabel() == "magnitude [dB re 1 m/V]"
        assert (below.get_ylabel(), below.get_xlabel()) == ("phase [deg]", "frequency [Hz]")
        assert above.get_xscale() == below.get_xscale() == "log"
        (legend,) = drawn.legends
        assert len(legend.get_texts()) == 5  # three designs and two marks
        marked = [text.get_text().strip() for text in above.texts]
        assert marked == ["valve 250 Hz", "valve 400 Hz"][: 1 + ("recommended_fast_valve" in cases)]


def test_the_root_locus_crosses_where_the_phase_does(paper: Reproduction) -> None:
    """At the limit each design's pair stands on the imaginary axis, at the phase crossover of the open loop."""
    (axes,) = root_locus(paper).axes
    diamonds = [line for line in axes.lines if line.get_marker() == "D"]
    crossing = sorted(float(line.get_ydata()[0]) for line in diamonds if abs(float(line.get_xdata()[0])) < 1e-6)
    designs = [(paper.cases | paper.variants)[name].actuator for name in FIGURES["figure-7"][1]]
    expected = sorted(
        PositionLoop.of_actuator(one, paper.study.mass).phase_crossover / (2 * math.pi) for one in designs
    )
    assert [place for place in crossing if place > 0.0] == pytest.approx(expected, rel=1e-6)


# --- refusals ------------------------------------------------------------------------------------------------------


def test_unknown_names_are_refused_with_the_known_ones(paper: Reproduction) -> None:
    with pytest.raises(InputError, match="case = 'bigger': must be one of initial, volume_double"):
        PaperStudy().design("bigger")
    with pytest.raises(InputError, match="figure = 'figure-9': must be one of figure-3"):
        figure(paper, "figure-9")


@pytest.mark.parametrize(
    "change", [{"factor": 0.0}, {"fast_valve": -1.0}, {"reading_gain": math.inf}, {"large_signal_valve": math.nan}]
)
def test_values_must_be_physical(change: dict[str, float]) -> None:
    with pytest.raises(InputError, match=f"{next(iter(change))} = .*: must be a positive, finite number"):
        PaperStudy(**change)  # type: ignore[arg-type]

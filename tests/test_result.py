"""What comes back from a run: labels and units, the numbers of the summary, and the files."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import xarray as xr

import ehamj
from ehamj.errors import InputError, SimulationFailed
from ehamj.judge.brief import brief
from ehamj.judge.extremes import peak_and_rms
from ehamj.result import Result, load_result, written_whole
from ehamj.run.failures import Incomplete
from ehamj.run.many import simulate_many
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

AMPLITUDE, FREQUENCY = 2e-6, 12.5  # of the floor, vertical [m, Hz]
SHORT = {
    "name": "short",
    "duration": 0.12,
    "seed": 7,
    "plates": "tied",
    "ground": {"kind": "sine", "dof": "z", "amplitude": AMPLITUDE, "frequency": FREQUENCY},
    "control": {
        "kind": "open-loop",
        "signals": [{"kind": "sine", "mounts": ["rear-left"], "amplitude": 0.1, "frequency": 30.0}],
    },
}

MOUNTS = ["front-left", "front-right", "rear-left", "rear-right"]
LABELS = {
    "mount": MOUNTS,
    "axis": ["x", "y", "z"],
    "dof": ["x", "y", "z", "rx", "ry", "rz"],
    "chamber": [1, 2],
    "point": ["spindle-nose"],
}
# Typed from the published interface: dimensions after time, and SI units with the spool in mA and the command in V.
VARIABLES = {
    "ground_displacement": (("mount", "axis"), "m"),
    "ground_velocity": (("mount", "axis"), "m/s"),
    "ground_acceleration": (("mount", "axis"), "m/s^2"),
    "machine_displacement": (("dof",), "m"),
    "machine_velocity": (("dof",), "m/s"),
    "foot_displacement": (("mount", "axis"), "m"),
    "foot_velocity": (("mount", "axis"), "m/s"),
    "foot_acceleration": (("mount", "axis"), "m/s^2"),
    "cg_displacement": (("axis",), "m"),
    "cg_velocity": (("axis",), "m/s"),
    "cg_acceleration": (("axis",), "m/s^2"),
    "point_displacement": (("point", "axis"), "m"),
    "point_velocity": (("point", "axis"), "m/s"),
    "point_acceleration": (("point", "axis"), "m/s^2"),
    "stroke": (("mount",), "m"),
    "stroke_velocity": (("mount",), "m/s"),
    "spool": (("mount",), "mA"),
    "valve_command": (("mount",), "V"),
    "actuator_force": (("mount",), "N"),
    "chamber_pressure": (("mount", "chamber"), "Pa"),
    "chamber_flow": (("mount", "chamber"), "m^3/s"),
    "supply_pressure": ((), "Pa"),
}


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(parse_scenario(SHORT))


@pytest.fixture(scope="module")
def folder(result: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("result")
    result.write(path)
    return path


@pytest.fixture(scope="module")
def failed() -> Incomplete:
    """A step of 5 ms is far beyond what explicit integration of 500 Hz oil modes stands."""
    table = {**SHORT, "timestep": 5e-3, "record_rate": 200.0, "duration": 1.0}
    with pytest.raises(SimulationFailed) as caught:
        simulate(parse_scenario(table))
    assert isinstance(caught.value, Incomplete)
    return caught.value


def strict_json(text: str) -> Any:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def leaves(node: Any) -> Iterator[Any]:
    """Every value in nested dictionaries."""
    for value in node.values():
        if isinstance(value, dict):
            yield from leaves(value)
        else:
            yield value


# --- labels and units ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", VARIABLES)
def test_variable_has_its_dimensions_and_units(result: Result, name: str) -> None:
    dimensions, units = VARIABLES[name]
    variable = result.dataset[name]
    assert variable.dims == ("time", *dimensions)
    assert variable.attrs["units"].split(" ")[0] == units


def test_rotations_say_that_they_are_rotations(result: Result) -> None:
    assert "rad" in result.dataset["machine_displacement"].attrs["units"]
    assert "rad/s" in result.dataset["machine_velocity"].attrs["units"]


def test_everything_has_a_long_name_and_a_unit(result: Result) -> None:
    for name, variable in result.dataset.variables.items():
        assert variable.attrs.get("long_name"), name
        assert variable.attrs.get("units") or name in LABELS, name


def test_nothing_is_lacking_or_not_finite(result: Result) -> None:
    assert set(result.dataset.data_vars) >= set(VARIABLES)
    for name, variable in result.dataset.data_vars.items():
        assert np.isfinite(variable.values).all(), name


@pytest.mark.parametrize("dimension", LABELS)
def test_labels_are_in_the_published_order(result: Result, dimension: str) -> None:
    assert result.dataset[dimension].values.tolist() == LABELS[dimension]


def test_time_runs_from_zero_to_the_duration_at_the_record_rate(result: Result) -> None:
    time = result.dataset["time"]
    assert time.attrs["units"] == "s"
    # Rounding of a product of a step number and a step.
    np.testing.assert_allclose(time.values, np.arange(121) / 1000.0, rtol=0, atol=1e-15)


# --- what the numbers are -----------------------------------------------------------------------------------------


def test_ground_is_what_was_asked_for(result: Result) -> None:
    omega = 2 * np.pi * FREQUENCY
    sine, cosine = (f(omega * result.dataset["time"].values) for f in (np.sin, np.cos))
    wanted = (AMPLITUDE * sine, AMPLITUDE * omega * cosine, -AMPLITUDE * omega**2 * sine)
    for name, values in zip(("displacement", "velocity", "acceleration"), wanted, strict=True):
        ground = result.dataset[f"ground_{name}"]
        for mount in MOUNTS:
            # The angle reaches 10 rad; its rounding is 1e-15 of the amplitude.
            np.testing.assert_allclose(
                ground.sel(mount=mount, axis="z"), values, rtol=0, atol=1e-14 * np.abs(values).max()
            )
        assert not ground.sel(axis=["x", "y"]).any()


def test_command_is_what_was_asked_for(result: Result) -> None:
    wanted = 0.1 * np.sin(2 * np.pi * 30.0 * result.dataset["time"].values)
    # An open-loop command reaches the valve as cubics over a step: exact where they begin, up to rounding.
    np.testing.assert_allclose(result.dataset["valve_command"].sel(mount="rear-left"), wanted, rtol=0, atol=1e-14)
    assert not result.dataset["valve_command"].sel(mount=["front-left", "front-right", "rear-right"]).any()


def test_force_is_area_times_pressure_difference(result: Result) -> None:
    pressure = result.dataset["chamber_pressure"]
    wanted = 3.18e-2 * (pressure.sel(chamber=1) - pressure.sel(chamber=2))
    # The difference of two forces of 1e5 N, each rounded.
    np.testing.assert_allclose(result.dataset["actuator_force"].values, wanted.values, rtol=0, atol=1e-10)


def test_stroke_is_foot_over_ground(result: Result) -> None:
    # Tied plates move with the feet. Tilting adds terms of second order, (1e-7 rad)² · 1 m, below rounding here.
    for name in ("displacement", "velocity"):
        over = (result.dataset[f"foot_{name}"] - result.dataset[f"ground_{name}"]).sel(axis="z")
        stroke = result.dataset["stroke" if name == "displacement" else "stroke_velocity"]
        np.testing.assert_allclose(stroke.values, over.values, rtol=0, atol=1e-12 * np.abs(stroke.values).max())


def test_velocity_is_the_derivative_of_displacement() -> None:
    dataset = simulate(parse_scenario({**SHORT, "duration": 0.03, "record_rate": 20e3})).dataset
    # A central difference over 2h errs by (ωh)²/6: 0.52 % for the fastest mode, 560 Hz.
    for name in ("foot", "cg", "machine"):
        displacement, velocity = (dataset[f"{name}_{kind}"].values for kind in ("displacement", "velocity"))
        difference = (displacement[2:] - displacement[:-2]) * 10e3
        assert np.abs(difference - velocity[1:-1]).max() < 0.006 * np.abs(velocity).max()


def test_supply_is_constant(result: Result) -> None:
    assert (result.dataset["supply_pressure"] == 70e5).all()


# --- summary ------------------------------------------------------------------------------------------------------


def test_summary_has_what_a_person_asks_for(result: Result) -> None:
    assert set(result.summary) >= {
        *("peak", "rms", "saturation", "oil", "timing", "versions", "seed", "complete", "warnings"),
    }
    assert (result.summary["seed"], result.summary["complete"], result.complete) == (7, True, True)


@pytest.mark.parametrize("name", VARIABLES)
def test_peak_and_rms_are_about_equilibrium(result: Result, name: str) -> None:
    variable = result.dataset[name]
    # The run begins in equilibrium; only a command may jump at once, so it counts from zero.
    about = variable.values - (0.0 if name == "valve_command" else variable.values[0])
    peak, rms = np.abs(about).max(axis=0), np.sqrt(np.mean(about * about, axis=0))
    for given, wanted in ((result.summary["peak"][name], peak), (result.summary["rms"][name], rms)):
        flat = list(leaves(given)) if isinstance(given, dict) else [given]
        # The same sums in another order: rounding only.
        np.testing.assert_allclose(flat, wanted.ravel(), rtol=1e-12)


def test_peak_is_labelled(result: Result) -> None:
    peak = result.summary["peak"]
    z = np.abs(result.dataset["ground_velocity"].values[:, 1, 2] - result.dataset["ground_velocity"].values[0, 1, 2])
    assert peak["ground_velocity"]["front-right"]["z"] == pytest.approx(z.max(), rel=1e-12)
    assert list(peak["chamber_pressure"]["rear-left"]) == ["1", "2"]


def test_a_command_held_from_the_start_has_a_peak() -> None:
    signal = {"kind": "step", "amplitude": 0.5, "mounts": ["rear-left"]}
    table = {**SHORT, "duration": 0.01, "control": {"kind": "open-loop", "signals": [signal]}}
    peak = simulate(parse_scenario(table)).summary["peak"]["valve_command"]
    assert peak == {"front-left": 0.0, "front-right": 0.0, "rear-left": 0.5, "rear-right": 0.0}


def test_oil_of_a_steady_run_is_steady() -> None:
    # A command held since before the start, ground at rest: the same flow in every state, so mean and peak are one.
    signal = {"kind": "step", "amplitude": 2.0, "start": -1.0, "mounts": ["rear-left"]}
    control = {"kind": "open-loop", "signals": [signal]}
    table = {**SHORT, "duration": 0.05, "ground": {"kind": "rest"}, "control": control}
    oil = simulate(parse_scenario(table)).summary["oil"]
    flow = oil["peak_flow_m3_s"]
    assert flow > 0
    # The equilibrium is solved to about 1e-9 of the supply's pressure.
    assert oil["mean_flow_m3_s"] == pytest.approx(flow, rel=1e-6)
    assert oil["volume_m3"] == pytest.approx(flow * 0.05, rel=1e-6)
    assert oil["mean_power_w"] == pytest.approx(flow * 70e5, rel=1e-6)


def test_levels_of_what_is_not_finite_are_null() -> None:
    values = np.array([[0.0, 0.0], [1.0, np.nan], [2.0, np.nan]])
    dataset = xr.Dataset({"stroke": (("time", "mount"), values)}, {"mount": ["front-left", "front-right"]})
    peak, rms = peak_and_rms(dataset.isel(time=[0, 1]).assign(spool=("time", [0.0, np.inf])))
    assert peak["stroke"]["front-left"] == 1.0
    assert peak["spool"] is None
    assert rms["spool"] is None


def test_timing_adds_up(result: Result) -> None:
    timing = result.summary["timing"]
    assert timing["simulated_s"] == pytest.approx(0.12, rel=1e-12)
    assert timing["steps"] * timing["timestep_s"] == pytest.approx(0.12, rel=1e-12)
    assert timing["ratio"] == pytest.approx(timing["simulated_s"] / timing["stepping_s"], rel=1e-12)
    assert 0 < timing["stepping_s"] <= timing["wall_s"]


def test_saturation_counts_the_share_of_time_at_a_limit() -> None:
    # 12 V are asked for, 10 V allowed: a sine is beyond for 1 − 2/π·asin(10/12) of its period, on one mount.
    signal = {"kind": "sine", "amplitude": 12.0, "frequency": 50.0, "mounts": ["front-right"]}
    table = {**SHORT, "duration": 0.1, "control": {"kind": "open-loop", "signals": [signal]}}
    share = simulate(parse_scenario(table)).summary["saturation"]["command"]
    # Five periods of at least a hundred steps; each of ten crossings of the limit, in and out, may be a step off.
    assert share["front-right"] == pytest.approx(1 - 2 / np.pi * np.arcsin(10 / 12), abs=20 / 500)
    assert [share[mount] for mount in ("front-left", "rear-left", "rear-right")] == [0.0, 0.0, 0.0]


def test_a_limit_that_was_reached_is_a_warning() -> None:
    signal = {"kind": "step", "amplitude": 11.0, "mounts": ["front-right"]}
    table = {**SHORT, "duration": 0.01, "control": {"kind": "open-loop", "signals": [signal]}}
    warnings = simulate(parse_scenario(table)).summary["warnings"]
    assert "the command was at its limit for up to 100 % of the time (front-right)" in warnings


# --- files --------------------------------------------------------------------------------------------------------


def test_saved_files(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {"scenario.toml", "model.xml", "result.nc", "summary.json"}


def test_saved_and_loaded_is_the_same(result: Result, folder: Path) -> None:
    loaded = load_result(folder)
    xr.testing.assert_identical(loaded.dataset, result.dataset)
    assert loaded.scenario == result.scenario
    assert loaded.summary == result.summary
    assert loaded.model_xml == result.model_xml


def test_file_is_netcdf_that_plain_xarray_opens(result: Result, folder: Path) -> None:
    assert (folder / "result.nc").read_bytes().startswith(b"\x89HDF\r\n\x1a\n")  # NetCDF-4 is HDF5
    with xr.open_dataset(folder / "result.nc") as opened:
        xr.testing.assert_identical(opened.load(), result.dataset)


def test_summary_file_is_strict_json(result: Result, folder: Path) -> None:
    found = strict_json((folder / "summary.json").read_text(encoding="utf-8"))
    assert found.pop("belongs")["run"] == result.identity
    assert found == result.summary


def test_saved_model_opens_by_itself(folder: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    # 4000 kg and four plates of 14 kg, whichever bodies carry them; a file keeps about six digits.
    assert model.body_subtreemass[0] >= 4000.0


def test_a_result_of_another_make_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is no result folder, scenario\.toml is missing"):
        load_result(tmp_path)


@pytest.mark.parametrize("name", ["result.nc", "summary.json"])
def test_a_damaged_result_is_refused(folder: Path, tmp_path: Path, name: str) -> None:
    for path in folder.iterdir():
        content = path.read_bytes()
        (tmp_path / path.name).write_bytes(content[: len(content) // 2] if path.name == name else content)
    with pytest.raises(InputError, match="is damaged"):
        load_result(tmp_path)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda summary: summary.pop("oil"), "summary.json: oil: is missing"),
        (lambda summary: summary.update(old=1), "summary.json: old: is no key of it"),
        (lambda summary: summary["timing"].update(steps="many"), r"summary.json: timing.steps: .*integer"),
        (lambda summary: summary["criterion"]["floor"]["x"].pop("class"), "criterion.floor.x.class: is missing"),
    ],
)
def test_a_summary_of_another_make_is_refused(folder: Path, tmp_path: Path, spoil: Any, said: str) -> None:
    for path in folder.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    spoil(summary)
    (tmp_path / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    with pytest.raises(InputError, match=said):
        load_result(tmp_path)


def test_a_summary_reads_by_attribute_and_by_key(result: Result) -> None:
    summary = result.summary
    assert summary["timing"]["steps"] == summary.timing.steps
    assert summary["criterion"]["machine"]["z"]["class"] == summary.criterion.machine.z.met
    assert {**summary} == summary == summary.changed()
    assert ("failure" in summary, summary.get("failure"), summary.failure) == (False, None, None)


def half_written(path: Path, interruption: BaseException) -> None:
    with written_whole(path) as temporary:
        temporary.write_bytes(b"half")
        raise interruption


def test_written_whole_leaves_nothing_behind_on_failure(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="disk full"):
        half_written(tmp_path / "result.nc", OSError("disk full"))
    assert not list(tmp_path.iterdir())


def test_written_whole_keeps_the_old_file_on_failure(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        half_written(tmp_path / "summary.json", KeyboardInterrupt())
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("summary.json", "old")]


def test_written_whole_replaces(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("old")
    with written_whole(tmp_path / "summary.json") as path:
        assert path.suffix == ".json"  # writers choose a format by it
        path.write_text("new")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("summary.json", "new")]


# --- the same again -----------------------------------------------------------------------------------------------


def test_resolved_scenario_runs_again_to_the_same_result(result: Result, folder: Path) -> None:
    again = simulate(load_scenario(folder / "scenario.toml"))
    xr.testing.assert_identical(again.dataset, result.dataset)


def test_a_record_runs_again_to_the_same_result(tmp_path: Path) -> None:
    ground = {"kind": "record", "file": "example:BW.RJOB", "scale": 20.0, "start": 3.0, "taper": 0.05}
    first = simulate(parse_scenario({**SHORT, "ground": ground, "duration": 0.05}))
    first.write(tmp_path)
    again = simulate(load_scenario(tmp_path / "scenario.toml"))
    xr.testing.assert_identical(again.dataset, first.dataset)


def test_runs_side_by_side_are_the_same_as_alone(result: Result) -> None:
    scenario = parse_scenario(SHORT)
    for one in simulate_many([scenario, scenario, scenario], threads=2):
        xr.testing.assert_identical(one.dataset, result.dataset)


def test_record_rates_agree_at_common_times() -> None:
    fast, slow = (
        simulate(parse_scenario({**SHORT, "timestep": 1e-4, "record_rate": rate})).dataset for rate in (1000.0, 250.0)
    )
    # The same steps, so the same numbers to the last bit; time itself is a step number times the step.
    assert slow.attrs.pop("run") != fast.attrs.pop("run")
    xr.testing.assert_identical(slow, fast.isel(time=slice(None, None, 4)))


# --- a run that fails ---------------------------------------------------------------------------------------------


def test_a_failed_run_keeps_what_it_has(failed: Incomplete) -> None:
    dataset = failed.result.dataset
    assert 1 <= dataset.sizes["time"] < 201
    assert set(dataset.data_vars) >= set(VARIABLES)


def test_a_failed_run_is_marked_incomplete(failed: Incomplete) -> None:
    assert failed.result.complete is False
    assert failed.result.summary["complete"] is False
    assert failed.result.dataset.attrs["complete"] == 0
    assert failed.result.summary["failure"] == str(failed)
    assert not any("decide" in warning or "than the floor" in warning for warning in failed.result.summary["warnings"])
    assert set(brief(failed.result.summary)) == {"run", "until then", "warnings", "more"}


def test_a_failed_run_is_saved_and_loaded(failed: Incomplete, tmp_path: Path) -> None:
    failed.result.write(tmp_path)
    loaded = load_result(tmp_path)
    assert not loaded.complete
    xr.testing.assert_identical(loaded.dataset, failed.result.dataset)
    strict_json((tmp_path / "summary.json").read_text(encoding="utf-8"))


def test_published_names_are_there() -> None:
    for name in ("load_scenario", "Scenario", "simulate", "simulate_many", "Result", "load_result"):
        assert callable(getattr(ehamj, name))


def test_limits_are_dated() -> None:
    scenario = parse_scenario(
        {
            "duration": 0.3,
            "plates": "tied",
            "control": {
                "kind": "open-loop",
                "signals": [{"kind": "step", "mounts": ["rear-left"], "amplitude": 12.0, "start": 0.1}],
            },
        }
    )
    found = simulate(scenario).summary["at_limit"]
    # The step stands from its start to the end, 0.1 to 0.3 s at rows of 1 ms, the last one included.
    assert found["command"] == {"first_s": 0.1, "longest_s": pytest.approx(0.201), "mount": "rear-left"}
    assert found["cavitation"] is None

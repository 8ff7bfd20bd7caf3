"""The numbers a person asks for first, from a run's dataset and its tally."""

import platform
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr

from ehamj.control import LinearController
from ehamj.judge import isolation
from ehamj.judge.relative import relative_motions
from ehamj.judge.spectra import response_spectra
from ehamj.linear.loop import Loop, feeds_back
from ehamj.linear.machine import linear_model
from ehamj.linear.margins import report
from ehamj.mujoco.rows import DRAWN, LIMITS, Tally
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.model import Scenario

REPORTED_VERSIONS = ("ehamj", "mujoco", "numpy", "scipy", "numba", "control", "rerun-sdk", "xarray", "obspy")

UNSTABLE = "the control loop is unstable: the linear machine runs away under this law"


def summarise(
    *,
    scenario: Scenario,
    dataset: xr.Dataset,
    tally: Tally,
    steps: int,
    timestep: float,
    stepping_seconds: float,
    total_seconds: float,
    complete: bool,
    notes: tuple[str, ...],
    usable_to: float,
    law: LinearController | None = None,
) -> dict[str, Any]:
    """The content of summary.json: plain numbers, SI, null where something is undefined."""
    peak, rms = levels(dataset)
    simulated = float(dataset.time[-1]) if dataset.time.size else 0.0
    states = max(steps + complete, 1)  # counted: one before each step and, at the end of a complete run, the last one
    saturation = _saturation(tally, states)
    isolated = isolation(dataset, scenario.plant, scenario.record_rate, usable_to, scenario.criteria)
    undecided = isolated.pop("undecided")
    margins = loop_margins(scenario, law)
    unstable = [UNSTABLE] if margins is not None and not margins["stable"] else []
    return {
        "name": scenario.name,
        "complete": complete,
        **isolated,
        **_observed(dataset, scenario, usable_to),
        "warnings": [*notes, *unstable, *undecided, *_warnings(saturation)],
        "peak": peak,
        "rms": rms,
        "saturation": saturation,
        "at_limit": at_limit(dataset, scenario),
        "oil": _oil(tally, states, steps * timestep),
        "margins": margins,
        "timing": {
            "simulated_s": simulated,
            "wall_s": total_seconds,
            "stepping_s": stepping_seconds,
            "steps": steps,
            "timestep_s": timestep,
            "ratio": simulated / stepping_seconds if stepping_seconds > 0 else None,
        },
        "versions": {"python": platform.python_version(), **{name: version(name) for name in REPORTED_VERSIONS}},
        "seed": scenario.seed,
    }


def loop_margins(scenario: Scenario, law: LinearController | None) -> dict[str, Any] | None:
    """Margins of the law's loop (`ehamj.linear.margins`), worst of all places and of each motion; None without."""
    if law is None or not feeds_back(law):
        return None
    return report(linear_model(scenario.plant), Loop.of(scenario, law)).to_dict(places=("motions",))


def _observed(dataset: xr.Dataset, scenario: Scenario, usable_to: float) -> dict[str, Any]:
    """What the scenario asks for beside: relative motions and response spectra."""
    observed: dict[str, Any] = {}
    if scenario.relative:
        observed["relative"] = relative_motions(dataset, scenario.relative, scenario.record_rate, usable_to)
    if scenario.criteria.response_spectrum is not None:
        settings = scenario.criteria.response_spectrum
        observed["response_spectrum"] = response_spectra(dataset, scenario.record_rate, usable_to, settings)
    return observed


def levels(dataset: xr.Dataset) -> tuple[dict[str, Any], dict[str, Any]]:
    """Peak and RMS of every variable and channel about its first value, which is the equilibrium; commands about 0.

    States of the controller are left out: nobody asks for them first.
    """
    peak: dict[str, Any] = {}
    rms: dict[str, Any] = {}
    for name, variable in dataset.data_vars.items():
        if not variable.size or name == "controller_state":
            continue
        about = variable if name == "valve_command" else variable - variable[0]
        peak[str(name)] = _nested(abs(about).max("time"))
        rms[str(name)] = _nested((about**2).mean("time") ** 0.5)
    return peak, rms


def _nested(values: xr.DataArray) -> Any:
    """Labelled numbers as nested dictionaries; a number that is not finite becomes null."""
    if values.ndim == 0:
        number = float(values)
        return number if np.isfinite(number) else None
    dimension = values.dims[0]
    return {str(label): _nested(values.sel({dimension: label})) for label in values[dimension].values}


def at_limit(dataset: xr.Dataset, scenario: Scenario) -> dict[str, Any]:
    """When each limit was reached, by the recorded rows: per kind the first time, the longest stretch [s], its mount.

    None where a limit was not reached in any recorded row; `saturation` counts every step.
    """
    plant = scenario.plant
    command, spool = dataset["valve_command"].values, dataset["spool"].values
    limit, stroke, gain, frequency, drive = (
        np.array([getattr(actuator, name) for actuator in plant.actuators])
        for name in ("voltage_limit", "spool_stroke", "valve_gain", "valve_frequency", "spool_drive_limit")
    )
    target = gain * np.clip(command, -limit, limit)
    reached = {
        "command": np.abs(command) >= limit,
        "spool": np.abs(spool) >= stroke,
        "spool_drive": np.abs(frequency**2 * (target - spool)) >= drive,
        "cavitation": (dataset["chamber_void"].values > 0.0).any(axis=2),
    }
    return {name: _stretches(states, scenario.record_rate) for name, states in reached.items()}


def _stretches(states: np.ndarray, rate: float) -> dict[str, Any] | None:
    """First time and longest stretch [s] of states (time, mount), None if they are never true."""
    if not states.any():
        return None
    longest, where = 0, 0
    for mount in range(states.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], states[:, mount].astype(int), [0]])))
        lengths = edges[1::2] - edges[::2]
        if lengths.size and int(lengths.max()) > longest:
            longest, where = int(lengths.max()), mount
    first = int(np.argmax(states.any(axis=1)))
    return {"first_s": first / rate, "longest_s": longest / rate, "mount": MOUNTS[where]}


def _saturation(tally: Tally, states: int) -> dict[str, dict[str, float]]:
    """Share of states at each limit, per mount."""
    shares = {name: tally.limits[name] / states for name in LIMITS.names or ()}
    return {name: dict(zip(MOUNTS, map(float, each), strict=True)) for name, each in shares.items()}


def _oil(tally: Tally, states: int, duration: float) -> dict[str, float]:
    drawn = {name: float(tally.drawn[name][0]) for name in DRAWN.names or ()}
    return {
        "mean_flow_m3_s": drawn["flow"] / states,
        "peak_flow_m3_s": drawn["peak_flow"],
        "volume_m3": drawn["flow"] / states * duration,
        "mean_power_w": drawn["power"] / states,
    }


def _warnings(saturation: dict[str, dict[str, float]]) -> list[str]:
    words = {
        "command": "the command was at its limit",
        "spool": "the spool was fully open",
        "spool_drive": "the spool's drive was at its limit",
        "cavitation": "oil cavitated",
    }
    found = []
    for name, shares in saturation.items():
        mount, share = max(shares.items(), key=lambda item: item[1])
        if share > 0:
            found.append(f"{words[name]} for up to {100 * share:.3g} % of the time ({mount})")
    return found

"""How the response changes with amplitude: sine commands from 1 to 90 % of full signal, measured in the simulation.

The paper's valve is a lag at any amplitude; the real one is slow at large signals, since its drive saturates, and the
root law of its edges bends with the load. Gain and phase are those of the fundamental (describing function).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from ehamj.paper.figures import FREQUENCY, MAGNITUDE, PHASE
from ehamj.plots import Figure, Line, lines_chart, svg
from ehamj.result import written_whole
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

SHARES = (0.01, 0.05, 0.25, 0.50, 0.90)
FREQUENCIES = (5.0, 10.0, 20.0, 50.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 300.0)
PERIODS = 10
"""Whole periods that a gain is taken from."""


@dataclass(frozen=True)
class AmplitudeStudy:
    """Which machine is driven how: all valves alike, ``shares`` of full command, at ``frequencies`` [Hz]."""

    scenario: Scenario
    shares: Sequence[float] = SHARES
    frequencies: Sequence[float] = FREQUENCIES
    settling: float = 1.0
    """Time before the evaluated periods [s]."""


def amplitude_response(study: AmplitudeStudy) -> xr.Dataset:
    """Response of spool and stroke to the command, by amplitude.

    Returns:
        ``spool_gain`` [mA/V], ``spool_phase`` [deg], ``stroke_gain`` [m/V], ``stroke_phase`` [deg] over ``share`` [-]
        and ``frequency`` [Hz].
    """
    limit = study.scenario.plant.actuators[0].voltage_limit
    cases = [(share * limit, hertz) for share in study.shares for hertz in study.frequencies]
    runs = observe_many((_driven(study.scenario, study.settling, *case) for case in cases), _first_mount)
    data, over = {}, ("share", "frequency")
    for name, unit, text in (("spool", "mA/V", "spool"), ("stroke", "m/V", "plate over the ground")):
        answers = [_fundamental(run, name, *case) for run, case in zip(runs, cases, strict=True)]
        answer = np.reshape(answers, (len(study.shares), len(study.frequencies)))
        phase = np.degrees(np.unwrap(np.angle(answer), axis=1))
        data[f"{name}_gain"] = (over, np.abs(answer), {"units": unit, "long_name": f"gain, command to {text}"})
        data[f"{name}_phase"] = (over, phase, {"units": "deg", "long_name": f"phase, command to {text}"})
    coordinates = {
        "share": ("share", list(study.shares), {"units": "1", "long_name": "command over its full range"}),
        "frequency": ("frequency", list(study.frequencies), {"units": "Hz", "long_name": "frequency"}),
    }
    return xr.Dataset(data, coordinates, {"title": f"amplitude dependence of {study.scenario.name}"})


def _driven(scenario: Scenario, settling: float, amplitude: float, hertz: float) -> Scenario:
    signal = {"kind": "sine", "amplitude": amplitude, "frequency": hertz}
    samples = int(np.ceil(8000.0 / hertz))  # per period: periods are whole numbers of rows, and steps fine enough
    table = scenario.model_dump() | {
        "ground": {"kind": "rest"},
        "control": {"kind": "open-loop", "signals": (signal,)},
        "compare": (),
        "plates": "tied",
        "duration": np.ceil(settling * hertz) / hertz + PERIODS / hertz,
        "record_rate": samples * hertz,
    }
    return parse_scenario(table)


def _first_mount(run: Observed) -> xr.Dataset:
    """Of the first mount, which all others are like: what gains are taken from."""
    return run.dataset[["spool", "stroke"]].isel(mount=0)


def _fundamental(part: xr.Dataset, name: str, amplitude: float, hertz: float) -> complex:
    """Complex gain at the driving frequency over the last whole periods."""
    rate = (part.sizes["time"] - 1) / float(part["time"][-1])
    last = slice(-round(PERIODS * rate / hertz), None)
    time, values = part["time"].values[last], part[name].values[last]
    line = 2.0 * np.mean((values - values.mean()) * np.exp(-2j * np.pi * hertz * time))
    return complex(line / (-1j * amplitude))


def amplitude_figure(response: xr.Dataset) -> Figure:
    """Gain and phase of the stroke over frequency, one line per amplitude."""
    panels: dict[str, list[Line]] = {MAGNITUDE: [], PHASE: []}
    for k, share in enumerate(response["share"].values):
        one, label = response.sel(share=share), f"±{100 * share:g} %"
        panels[MAGNITUDE].append(Line(label, one["frequency"], 20.0 * np.log10(one["stroke_gain"]), k))
        panels[PHASE].append(Line(label, one["frequency"], one["stroke_phase"], k))
    return lines_chart("Stroke over command, by amplitude of the command", FREQUENCY, panels, "x")


def write_amplitude(folder: Path, response: xr.Dataset) -> None:
    """Write ``amplitude.svg``, ``amplitude.png`` and ``amplitude.nc`` into a folder."""
    drawn = amplitude_figure(response)
    with written_whole(folder / "amplitude.svg") as path:
        path.write_text(svg(drawn, "amplitude"), encoding="utf-8")
    with written_whole(folder / "amplitude.png") as path:
        drawn.savefig(path, dpi=300)
    with written_whole(folder / "amplitude.nc") as path:
        response.to_netcdf(path, engine="h5netcdf")

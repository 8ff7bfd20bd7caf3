"""The figures of a design: its loops, what is predicted, and what limits it."""

from dataclasses import replace
from typing import Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.design.budget import Budget
from ehamj.judge.levels import SLAB
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel
from ehamj.linear.margins import grid, loop_gains
from ehamj.pages.words import AXIS_NAMES
from ehamj.plots import Figure, Levels, Line, attenuation, lines_chart, loop_figures
from ehamj.plots.charts import COLORS, DASHES
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing
from ehamj.synthesis.judged import Design

WORTH: Final = 0.01
"""Share of the machine's motion from which on a cause is shown."""


def loop_drawings(spectra: xr.Dataset) -> dict[str, Drawing]:
    """Gains and sensitivities of all motions on all machines, the others closed."""
    caption = (
        "Loop gain and sensitivity of each motion with the others closed: thick as designed, thin on the variations. "
        "Where the sensitivity lies below 0 dB the feedback quietens."
    )
    return {"loops": Drawing(caption, lambda: _loops_chart(spectra))}


def plotted(scenario: Scenario, model: LinearModel, design: Design) -> dict[str, Drawing]:
    """Bode and Nyquist plots, and where the scenario asks for them Nichols plots, with the disk that is asked for."""
    hertz = grid(design.law, model, dense=3)
    gains = loop_gains(model, Loop.of(scenario, design.law), hertz)
    figures = loop_figures(hertz, gains, design.requirements.disk_margin, scenario.output.nichols)
    return {name: Drawing(caption, draw) for name, (caption, draw) in figures.items()}


def budget_drawings(limits: Budget) -> dict[str, Drawing]:
    """What is predicted, and what limits it."""
    return {
        "attenuation": Drawing(
            "Attenuation that a run of scenario.toml will show: the floor of each mount through the closed loop.",
            lambda: _attenuation_chart(limits),
        ),
        "budget": Drawing(
            "Vertical velocity of the machine's centre of gravity by what causes it, and the floor's.",
            lambda: _budget_chart(limits),
        ),
    }


def valve_drawings(across: xr.Dataset) -> dict[str, Drawing]:
    """Gain and phase of a valve and of what linearises it over amplitude."""
    caption = (
        "What the valve and its linearisation give of a wanted opening, over its amplitude (describing function), by "
        "what the law believes of the overlap. Its gain is a gain of every loop: where it lies above 0 dB, that much "
        "of the gain margin is used."
    )
    return {"valves": Drawing(caption, lambda: _valve_chart(across))}


def _valve_chart(across: xr.Dataset) -> Figure:
    panels = {}
    for name in ("gain", "phase"):
        one = across[name]
        lines = [
            Line(f"overlap {belief}", across.amplitude.values, one.sel(overlap=belief).values, k, k)
            for k, belief in enumerate(across.overlap.values)
        ]
        panels[f"{one.attrs['long_name']} [{one.attrs['units']}]"] = lines
    return lines_chart("Valve over amplitude", "amplitude of the wanted opening [mA]", panels, "x")


def _loops_chart(table: xr.Dataset) -> Figure:
    panels = {}
    for quantity in ("gain", "sensitivity"):
        lines = []
        for row, machine in enumerate(table.machine.values):
            for column, pattern in enumerate(table.pattern.values):
                values = table[quantity].sel(machine=machine, pattern=pattern).values
                label = str(pattern) if row == 0 else ("on a variation" if column == 0 and row == 1 else "")
                width = 2.0 if row == 0 else 0.7
                lines.append(Line(label, table.frequency.values, values, column, min(row, 1), width=width))
        panels[f"{table[quantity].attrs['long_name']} [dB]"] = lines[::-1]
    limits = {"loop gain [dB]": (-40.0, 60.0), "sensitivity [dB]": (-60.0, 10.0)}
    return lines_chart("Loops", "frequency [Hz]", panels, "x", limits=limits)


def _attenuation_chart(limits: Budget) -> Figure:
    curves = [
        replace(Levels.of_bands(name, limits.attenuation[motion], COLORS[k]), dash=DASHES[k % len(DASHES)])
        for k, (motion, name) in enumerate(AXIS_NAMES.items())
        if any(value is not None for value in limits.attenuation[motion].values())
    ]
    return attenuation("Predicted attenuation", curves)


def _budget_chart(limits: Budget) -> Figure:
    z, micro = SLAB.index("z"), 1e6
    centres, total = [band.centre for band in limits.bands], limits.total[:, z]
    lines = [Line("floor", centres, micro * limits.floor[:, z], 7, width=2.4)]
    lines.append(Line("machine, all together", centres, micro * total, 0, width=2.4))
    for k, (name, values) in enumerate(telling(limits).items()):
        lines.append(Line(name, centres, micro * values[:, z], 1 + k % 6, 1 + k // 3 % 3, width=1.3))
    known = np.concatenate([limits.floor[:, z], total])
    known = known[np.isfinite(known) & (known > 0)]
    if not known.size:
        known = np.ones(1)
    quantity = "RMS velocity [µm/s]"
    limit = (max(1e-6, 0.1 * micro * float(known.min())), 3.0 * micro * float(known.max()))
    return lines_chart("Budget", "third-octave band [Hz]", {quantity: lines}, "xy", limits={quantity: limit})


def telling(limits: Budget) -> dict[str, Array]:
    """Contributions of which any is worth a word: a hundredth of the machine's vertical motion in some band."""
    z, total = SLAB.index("z"), limits.total[:, SLAB.index("z")]
    least = np.where(np.isfinite(total), WORTH * total, np.inf)
    return {name: values for name, values in limits.contributions.items() if np.any(values[:, z] > least)}

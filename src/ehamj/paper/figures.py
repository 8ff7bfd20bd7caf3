"""The paper's figures 3 to 7: magnitude and phase of G_EHA (eq. 9) of several designs."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.paper.actuator import Form, bode, delta_h, omega_h
from ehamj.paper.loop import PositionLoop
from ehamj.paper.reproduction import Reproduction
from ehamj.plots import Branch, Figure, Line, lines_chart, locus_chart, view_of
from ehamj.plots.charts import COLORS

FIGURES: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "figure-3": ("Open loop of the initial design: exact, and eq. 8 corrected and as printed", ("initial",)),
    "figure-4": ("Sensitivity of the open loop to the chamber volume", ("initial", "volume_double", "volume_half")),
    "figure-5": ("Sensitivity of the open loop to the piston area", ("initial", "area_double", "area_half")),
    "figure-6a": ("Sensitivity of the open loop to the flow gain", ("initial", "flow_gain_double", "flow_gain_half")),
    "figure-6b": (
        "Sensitivity of the open loop to the flow-pressure coefficient",
        ("initial", "flow_pressure_double", "flow_pressure_half"),
    ),
    "figure-7": (
        "Open loop of the initial and the recommended design, and of the latter with a faster valve",
        ("initial", "recommended", "recommended_fast_valve"),
    ),
}
"""The paper's figures: caption and cases. The paper numbers its last one 5 a second time; the text calls it 7."""

LOCUS: Final = (
    "Beyond the paper: closed-loop poles of a proportional position loop as its gain rises from zero past the highest "
    "that keeps 6 dB and 45° to the limit of stability. The pair that turns is the slower of valve and load's; the "
    "pole on the real axis says how fast errors go."
)
BEYOND, STEPS = 1.25, 81
"""How far beyond its limit a gain is followed, and how many gains there are up to each mark."""

FORMS: Final[dict[Form, str]] = {
    "exact": "exact, third order",
    "eq8": "eq. 8, damping term corrected",
    "eq8-printed": "eq. 8 as printed (undamped)",
}

SPAN: Final = (1.0, 2000.0)
"""Frequencies that the figures show [Hz]."""

MAGNITUDE, PHASE, FREQUENCY = "magnitude [dB re 1 m/V]", "phase [deg]", "frequency [Hz]"


def figure(reproduction: Reproduction, name: str) -> Figure:
    """One of the paper's `FIGURES`, drawn anew.

    Squares mark the hydro-mechanical frequency f_h, diamonds the phase crossover; vertical lines mark the valves.

    Raises:
        InputError: if there is no such figure.
    """
    if name not in FIGURES:
        raise InputError(f"figure = {name!r}: must be one of {', '.join(FIGURES)}")
    _, cases = FIGURES[name]
    mass, every = reproduction.study.mass, reproduction.cases | reproduction.variants
    designs: dict[str, tuple[Actuator, Form]] = {every[one].label: (every[one].actuator, "exact") for one in cases}
    if name == "figure-3":
        designs = {label: (every["initial"].actuator, form) for form, label in FORMS.items()}
    pairs: list[tuple[Line, Line]] = []
    for k, (label, (actuator, form)) in enumerate(designs.items()):
        pairs += _lines(label, actuator, mass, form, k)
    pairs.sort(key=lambda pair: pair[0].marker)  # marks below the lines, in the legend
    panels = dict(zip((MAGNITUDE, PHASE), zip(*pairs, strict=True), strict=True))
    valves = sorted({actuator.valve_frequency / (2.0 * math.pi) for actuator, _ in designs.values()})
    return lines_chart(
        f"{name.replace('-', ' ').capitalize()} of the paper", FREQUENCY, panels, "x",
        {f"valve {hertz:.0f} Hz": hertz for hertz in valves},
        {MAGNITUDE: (-200.0, -90.0), PHASE: (-460.0, 10.0)},
    )  # fmt: skip


def _lines(label: str, actuator: Actuator, mass: float, form: Form, k: int) -> list[tuple[Line, Line]]:
    """Magnitude and phase of one design: its line and its marks."""
    resonance = omega_h(actuator, mass) / (2.0 * math.pi)
    around = resonance * (1.0 + np.linspace(-0.02, 0.02, 401))
    places = {"": np.unique(np.concatenate([np.geomspace(*SPAN, 1200), around]))}
    if form != "eq8-printed":
        places["s"] = np.array([resonance])
        places["D"] = np.array([PositionLoop.of_actuator(actuator, mass, form).phase_crossover]) / (2.0 * math.pi)
    names = {"": f"{label}: f_h = {resonance:.0f} Hz, δ_h = {delta_h(actuator, mass):.3f}"}
    names |= {"s": "f_h", "D": "phase crossover at −180°"} if k == 0 else {"s": "", "D": ""}
    pairs = []
    for marker, hertz in places.items():
        magnitude, phase = bode(actuator, mass, hertz, form)
        line = Line(names[marker], hertz, 20.0 * np.log10(magnitude), k, k, marker)
        pairs.append((line, replace(line, y=phase)))
    return pairs


def root_locus(reproduction: Reproduction) -> Figure:
    """Poles of the closed position loop of figure 7's designs over its gain, by python-control's root locus."""
    import control

    every = reproduction.cases | reproduction.variants
    branches: list[Branch] = []
    for k, name in enumerate(FIGURES["figure-7"][1]):
        loop = PositionLoop.of_actuator(every[name].actuator, reproduction.study.mass)
        designed, limit = loop.highest_gain(6.0, 45.0), loop.stability_gain
        ends = (0.0, designed, limit, BEYOND * limit)
        gains = np.concatenate([np.linspace(ends[i], ends[i + 1], STEPS) for i in range(3)])
        poles = control.root_locus_map(control.tf([loop.numerator], loop.denominator), gains=gains).loci
        branches += [Branch(every[name].label, poles[:, j], COLORS[k]) for j in range(poles.shape[1])]
    marks = {"no gain": 0, "6 dB and 45°": STEPS, "limit of stability": 2 * STEPS}
    view = view_of(np.concatenate([branch.poles for branch in branches]))
    return locus_chart("Root locus of a position loop", branches, marks, [view])

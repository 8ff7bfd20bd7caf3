"""Synthesised laws under stated margins: loops as the weights give them, lowered motion by motion until these hold."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from ehamj.control import Controller
from ehamj.control.sensors import Sensors
from ehamj.errors import InputError
from ehamj.linear.machine import LinearModel
from ehamj.plant.levers import MOTIONS
from ehamj.plant.plant import Plant
from ehamj.synthesis.judged import Design, Worst, judged
from ehamj.synthesis.requirements import NOMINAL, Machines, Requirements, machines_of

if TYPE_CHECKING:
    from ehamj.synthesis.settings import MotionWeights, SynthesisSettings

BEYOND: Final = 0.98
"""So much lower a loop is made than what it lacks of gain or disk margin asks for."""
LOWER: Final = 0.85
"""Least factor on a loop in one try, and factor on the bandwidth of one whose phase margin is too small."""
NOTHING: Final = (0.0, np.inf, 0.0)
"""Margins of a motion that is not known to lack any, where all lack some together."""
SLOWER: Final = 0.7
"""Factor on the integral of a loop whose phase margin is too small: a lower gain alone makes that smaller still."""
TRIES: Final = 16


@dataclass(frozen=True)
class Found:
    """A law that was found for a machine, and what it took."""

    design: Design
    nominal: LinearModel
    """The machine, linearised."""
    seconds: float
    """That finding took [s]."""

    @property
    def settings(self) -> "SynthesisSettings":
        """Whose weights leave the margins."""
        return self.design.settings  # type: ignore[return-value]

    @property
    def law(self) -> Controller:
        """What was found."""
        return self.design.law.parts[0]


def find(settings: "SynthesisSettings", plant: Plant, sensors: Sensors) -> Found:
    """The law that settings find for a plant and instruments, under their own margins.

    Raises:
        InputError: as `synthesised`.
    """
    began = time.perf_counter()
    machines = machines_of(plant, settings.variations, settings.known(plant, sensors), outside=True)
    design = synthesised(settings, plant, sensors, machines)
    return Found(design, machines[NOMINAL], time.perf_counter() - began)


def synthesised(
    settings: "SynthesisSettings",
    plant: Plant,
    sensors: Sensors,
    machines: Machines,
    progress: Callable[[str], None] = lambda words: None,
    seed: int = 0,
) -> Design:
    """The law of a synthesis that leaves its margins on a machine and all its variations.

    Where a motion lacks gain or disk margin its loop is lowered by that, where it lacks phase its weights ask for less
    below a lower frequency, and the law is found anew.

    Args:
        settings: weights to begin with, and margins.
        plant: that the law is derived from.
        sensors: that it reads.
        machines: the machine and its variations.
        progress: called with what is tried.
        seed: that draws the directions of misaligned instruments.

    Raises:
        InputError: if no law exists, or none leaves the margins.
    """
    wanted = settings.margins
    failure: InputError | None = None
    best: tuple[float, str] = (-1.0, "")
    for turn in range(TRIES):
        progress(f"{settings.kind}, try {turn + 1} of at most {TRIES}")
        lacking: dict[str, Worst] = {}
        try:
            feedback = settings.feedback(plant, sensors, machines[NOMINAL], seed)
        except InputError as error:
            said = f"{error} (the {settings.kind} synthesis, try {turn + 1} of {TRIES})"
            failure = failure or InputError(said)  # the first: what follows may be of what was eased
        else:
            design = judged(settings, feedback, sensors, machines, wanted, seed)
            if design.meets:
                return replace(design, law=settings.with_feedforward(feedback, plant, sensors))
            lacking = {name: design.worst_of(name) for name in MOTIONS if not design.leaves(name)}
            best = max(best, _nearest(design, wanted))
        settings = _eased(settings, lacking, wanted)
    if failure is not None and not best[1]:
        raise failure
    raise InputError(
        f"design: no {settings.kind} law was found that leaves {wanted.gain_margin:g} dB, {wanted.phase_margin:g}° and "
        f"a disk margin of {wanted.disk_margin:g} on every machine, with loops lowered {TRIES - 1} times; the nearest "
        f"{best[1]}. Ask for less (control.margins; --gain-margin, --phase-margin, --disk-margin of a design), or take "
        "the combined law (control.kind; --architecture combined of a design), whose crossings are tuned one by one"
    )


def _eased(settings: "SynthesisSettings", lacking: Mapping[str, Worst], wanted: Requirements) -> "SynthesisSettings":
    """Weights that ask for less of the motions that lack margins; of all where none does by itself."""
    changed: dict[str, MotionWeights] = {}
    for name in lacking or MOTIONS:
        own: MotionWeights = getattr(settings, name)
        gain, phase, disk = lacking.get(name, NOTHING)
        late, less = phase < wanted.phase_margin, {}
        if gain < wanted.gain_margin or (disk < wanted.disk_margin and not late):
            # A lower gain buys as much gain margin, and disk margin about in proportion.
            short = min(10.0 ** ((gain - wanted.gain_margin) / 20.0), disk / max(wanted.disk_margin, 1e-9))
            less["gain"] = own.gain * float(np.clip(BEYOND * short, LOWER, BEYOND))
        if late:
            less |= {"integral": SLOWER * own.integral, "bandwidth": LOWER * own.bandwidth}
        changed[name] = own.model_copy(update=less)
    return settings.model_copy(update=changed)


def _nearest(design: Design, wanted: Requirements) -> tuple[float, str]:
    """How near a design comes to the margins, one being there, and what it lacks most, in words."""
    found = []
    for machine, one in design.reports.items():
        if not one.stable:
            found.append((0.0, f"is unstable ({machine})"))
            continue
        asked = (
            ("gain", wanted.gain_margin, " dB"),
            ("phase", wanted.phase_margin, "°"),
            ("disk", wanted.disk_margin, ""),
        )
        for (value, place), (what, least, unit) in zip(one.worst_places, asked, strict=True):
            share = value / least if least > 0.0 else np.inf
            found.append((float(share), f"leaves a {what} margin of {value:.3g}{unit} ({machine}, {place})"))
    return min(found)

"""Automatic gains: the highest crossings that leave the required margins on a machine and all its variations.

The loop gain is linear in the crossings, L = Σ f_k L_k + L_0, so that one frequency response per loop and machine
serves every trial. Each crossing in turn is the highest that leaves its motion the margins, twice round; then all come
down together until the disk margin of all valves at once suffices. The law that comes out is judged again as a whole,
with the eigenvalues of its sampled loop.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.analysis.modes import modes
from ehamj.controllers import LinearController
from ehamj.controllers.combined import CombinedSettings
from ehamj.controllers.feedforward import FeedforwardSettings
from ehamj.controllers.inertial import MotionLoop
from ehamj.controllers.modal import MOTIONS, ModalSettings, SwayDamping, WarpBalance, plane
from ehamj.controllers.servo import StrokeServoSettings
from ehamj.controllers.skyhook import SkyhookSettings
from ehamj.design.requirements import Machines, Requirements
from ehamj.errors import InputError
from ehamj.layout import N_MOUNTS, WARP
from ehamj.linear.loops import LoopReport, disk_margin, grid, loop_gain, margins, report
from ehamj.scenario import Scenario

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Tunable = ModalSettings | SkyhookSettings | StrokeServoSettings
Trial = tuple[Array, ComplexArray, dict[str, ComplexArray]]
"""A machine: frequencies [Hz], loop gain of all but the loops, loop gain of each at a crossing of 1 Hz."""

STEP: Final = 1.03
STEPS: Final = 3.0 * STEP ** -np.arange(116.0)
"""Factors on a crossing that are tried, from 3 down to 0.1."""

REFERENCE: Final = {"heave": 528.0, "roll": 455.2, "pitch": 552.1, "sway x": 70.66, "sway y": 70.03}
"""Natural frequencies of the default machine [Hz], which the shapes of the loops were found for."""


@dataclass(frozen=True)
class Design:
    """A tuned law: its settings, and what it has in hand on each machine."""

    settings: Tunable | CombinedSettings | FeedforwardSettings
    law: LinearController
    reports: Mapping[str, LoopReport]
    requirements: Requirements

    @property
    def meets(self) -> bool:
        """Whether all machines are stable with the required margins."""
        return all(one.stable and holds(one.worst, self.requirements) for one in self.reports.values())


def holds(worst: tuple[float, float, float], requirements: Requirements) -> bool:
    """Whether gain [dB], phase [deg] and disk margin suffice."""
    gain, phase, disk = worst
    r = requirements
    return gain >= r.gain_margin and phase >= r.phase_margin and disk >= r.disk_margin


def tune(scenario: Scenario, machines: Machines, requirements: Requirements | None = None) -> Design:
    """Choose the crossings of a scenario's feedback.

    Args:
        scenario: whose control is tuned (modal, skyhook, stroke-servo, or combined with one of them).
        machines: the machine and its variations.
        requirements: margins.

    Raises:
        InputError: if the control has no loop to tune, or no crossing leaves the margins.
    """
    wanted = requirements or Requirements()
    control = scenario.control
    parts = control.parts if isinstance(control, CombinedSettings) else (control,)
    tunable = [part for part in parts if isinstance(part, Tunable)]
    if len(tunable) != 1:
        raise InputError(
            f"control.kind = {control.kind!r}: there must be one loop to tune, modal, skyhook or stroke-servo, "
            "alone or as one part of combined"
        )
    shaped = fitted(tunable[0], machines) if isinstance(tunable[0], ModalSettings) else tunable[0]
    tuned = _raised(shaped, scenario, machines, wanted)
    settings: Tunable | CombinedSettings = tuned
    if isinstance(control, CombinedSettings):
        others = tuple(tuned if part is tunable[0] else part for part in control.parts)
        settings = CombinedSettings.model_validate({**_plain(control), "parts": [_plain(part) for part in others]})
    return judged(settings, scenario, machines, wanted)


def judged(
    settings: Tunable | CombinedSettings | FeedforwardSettings,
    scenario: Scenario,
    machines: Machines,
    requirements: Requirements,
) -> Design:
    """The law of settings with its margins on every machine."""
    law = settings.controller(scenario.plant, scenario.sensors)
    reports = {name: report(model, law, scenario.sensors, scenario.seed) for name, model in machines.models.items()}
    return Design(settings, law, reports, requirements)


def _plain(settings: object) -> dict[str, object]:
    return settings.model_dump(exclude_none=True)  # type: ignore[attr-defined]


def fitted(settings: ModalSettings, machines: Machines) -> ModalSettings:
    """Modal loops moved to a machine's own resonances: notches by the oil's, sway damping by the sway's."""
    model = machines.models["as designed"]
    found = {mode.name: mode for mode in modes(model)}
    names = {
        "heave": "heave", "roll": "rocking about x", "pitch": "rocking about y",
        "sway x": "sway-rocking about y", "sway y": "sway-rocking about x",
    }  # fmt: skip
    ratio = {}
    for key, name in names.items():
        matching = [m for label, m in found.items() if label.endswith(name) and ("sway" in label) == ("sway" in name)]
        ratio[key] = matching[0].frequency / REFERENCE[key] if matching else 1.0
    changed: dict[str, object] = {}
    for motion in MOTIONS:
        loop: MotionLoop = getattr(settings, motion)
        changed[motion] = loop.model_copy(update={"notch": loop.notch * ratio[motion]})
    height = model.plant.machine.cg[2]
    for name in ("sway_x", "sway_y"):
        sway: SwayDamping = getattr(settings, name)
        by = ratio[name.replace("_", " ")]
        gain = sway.gain * 0.75 / max(height, 0.2) / by  # h ω g/2 is the damping added
        changed[name] = sway.model_copy(update={"centre": sway.centre * by, "gain": gain})
    return settings.model_copy(update=changed)


def _loops(settings: Tunable) -> dict[str, MotionLoop]:
    names = MOTIONS if isinstance(settings, ModalSettings) else ("loop",)
    return {name: loop for name in names if (loop := getattr(settings, name)).crossing}


def _only(settings: Tunable, name: str | None) -> Tunable:
    """The settings with one loop alone, of crossing 1 Hz; None: with everything but the loops."""
    changed: dict[str, object] = {}
    for other, loop in _loops(settings).items():
        changed[other] = loop.model_copy(update={"crossing": 1.0 if other == name else 0.0})
    if name is not None:
        off = WarpBalance(crossing=0.0)
        if isinstance(settings, ModalSettings):
            still = {"gain": 0.0}
            changed |= {"warp": off, "sway_x": settings.sway_x.model_copy(update=still)}
            changed |= {"sway_y": settings.sway_y.model_copy(update=still)}
    return settings.model_copy(update=changed)


def _raised(settings: Tunable, scenario: Scenario, machines: Machines, wanted: Requirements) -> Tunable:
    plant, sensors, seed = scenario.plant, scenario.sensors, scenario.seed
    loops = _loops(settings)
    everything = settings.controller(plant, sensors)
    rest = _only(settings, None).controller(plant, sensors)
    alone = {name: _only(settings, name).controller(plant, sensors) for name in loops}
    trials = []
    for model in machines.models.values():
        f = grid(everything, model)
        own = loop_gain(model, rest, f, sensors, seed)
        each = {name: loop_gain(model, law, f, sensors, seed) for name, law in alone.items()}
        if not isinstance(settings, ModalSettings):  # the loop alone still holds what the rest is
            each = {name: gain - own for name, gain in each.items()}
        trials.append((f, own, each))
    basis = np.column_stack([plane(plant), WARP])
    crossings = {name: loop.crossing for name, loop in loops.items()}
    for _ in range(2):
        for name, loop in loops.items():
            places = [MOTIONS.index(name)] if name in MOTIONS else list(range(N_MOUNTS))
            attempts = (crossings | {name: float(factor) * loop.crossing} for factor in STEPS)
            best = next(
                (a for a in attempts if all(_leaves(trial, a, basis, wanted, places) for trial in trials)), None
            )
            if best is None:
                raise InputError(
                    f"control: no crossing of the loop {name!r} up to {STEPS[0] * loop.crossing:.3g} Hz leaves the "
                    f"margins {wanted.gain_margin:g} dB, {wanted.phase_margin:g}° and {wanted.disk_margin:g} on every "
                    "variation; ask for less, or change the shape of the loop"
                )
            crossings = best
    while not all(_together(trial, crossings) >= wanted.disk_margin for trial in trials):
        crossings = {name: value / STEP for name, value in crossings.items()}
        if max(crossings.values()) < 1.0:
            raise InputError(
                f"control: no crossings leave a disk margin of {wanted.disk_margin:g} at all valves at once"
            )
    found = {name: loop.model_copy(update={"crossing": crossings[name]}) for name, loop in loops.items()}
    return settings.model_copy(update=found)


def _sensitivity(trial: Trial, crossings: dict[str, float]) -> ComplexArray:
    _, rest, each = trial
    loop = rest + sum(crossings[name] * gain for name, gain in each.items())
    return np.asarray(np.linalg.inv(np.eye(N_MOUNTS) + loop), complex)


def _leaves(trial: Trial, crossings: dict[str, float], basis: Array, wanted: Requirements, places: list[int]) -> bool:
    """Whether crossings leave the margins at some patterns of motion, and go round −1 nowhere there (Nyquist)."""
    moved = np.linalg.inv(basis) @ _sensitivity(trial, crossings) @ basis
    for k in places:
        difference = 1.0 / moved[:, k, k]
        if round(float(np.unwrap(np.angle(difference))[-1]) / (2 * np.pi)) != 0:
            return False
        one = margins(trial[0], difference - 1.0)
        if not holds((one.gain, one.phase, one.disk), wanted):
            return False
    return True


def _together(trial: Trial, crossings: dict[str, float]) -> float:
    """Disk margin of all valves at once."""
    return disk_margin(_sensitivity(trial, crossings))

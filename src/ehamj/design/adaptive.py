"""Adaptive cancellation of lines (filtered-x LMS): the motion at motors' and fans' frequencies, driven to nothing.

For each line ω, the motions that the mounts drive (heave, roll and pitch of upright ones) are asked for piston
velocities Re(w e^{jωt}), w (motion,) complex. With H (motion, motion) the response at ω from piston velocities to
measured velocities e of the machine, w follows

    w⁺ = (1 − T/``leak``)·w − (2T/``time``)·H⁻¹·e·e^{−jωt}.

That is the filtered-x LMS algorithm (Widrow and Stearns, Adaptive Signal Processing, 1985, ch. 11) with a step
normalised by H, so that every motion converges in the same ``time`` whatever the coupling. About its line it is a
narrow-band feedback (Glover, IEEE Trans. ASSP 25(6), 1977) of loop gain ``leak``/``time``: the line comes down to
1/(1 + leak/time), and the bandwidth is 1/(π·time) [Hz]. It needs no amplitude and no phase of the disturbance, and the
law below it stays as it is: with ``beside``, H is the response with that law closed.
"""

from dataclasses import asdict, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.control import Controller, PythonController
from ehamj.control.blocks import TWO_PI, Block
from ehamj.control.channels import MountChannels
from ehamj.control.inverse import volts
from ehamj.control.settings import SampledSettings
from ehamj.control.windup import AntiWindup
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.sampled import opened_at_samples
from ehamj.scenario.model import Scenario
from ehamj.settings import Positive


class LineSettings(SampledSettings):
    """Which lines are cancelled, and how fast."""

    kind: Literal["lines"] = "lines"
    lines: tuple[Positive, ...] = Field(description="frequencies of the lines [Hz]", min_length=1)
    time: Positive = Field(0.3, description="time in which a line comes down by e [s]")
    leak: Annotated[float, Field(gt=0)] = Field(
        15.0, description="time over which the weights are forgotten [s]; leak/time bounds the attenuation"
    )


def line_cancellation(
    scenario: Scenario, settings: LineSettings, beside: Controller | None = None, model: LinearModel | None = None
) -> PythonController:
    """A law that adapts to lines, by itself or on top of another law.

    >>> import ehamj
    >>> from ehamj.design.adaptive import LineSettings, line_cancellation
    >>> floor = {"kind": "sine", "frequency": 24.5, "amplitude": 1e-7}
    >>> scenario = ehamj.parse_scenario({"plates": "tied", "duration": 0.02, "ground": floor})
    >>> law = line_cancellation(scenario, LineSettings(lines=(24.5, 49.0)))
    >>> result = ehamj.simulate(scenario, controller=law)

    Args:
        scenario: machine and instruments.
        settings: lines and speed; of a law ``beside``, rate, delay, switch-on and the like are taken from there.
        beside: a law of one rate that runs at the same time.
        model: the linearised machine, where the caller has it already.

    Raises:
        InputError: if a line is at or above half the sampling rate.
    """
    plant = scenario.plant
    linear = model or linear_under(plant, beside)
    feet = MountChannels.of(plant).feet
    if beside is None:  # a law that commands nothing, with the clock of the settings
        nothing = Block.gain(np.zeros((len(plant.mounts), 0)))
        beside = settings.digital(nothing, (), plant, sensors=scenario.sensors, anti_windup=AntiWindup.NONE)
    law = _reading(beside, feet)
    high = [line for line in settings.lines if line >= 0.5 / law.period]
    if high:
        raise InputError(f"lines: {high[0]:g} Hz must be below half the sampling rate, {0.5 / law.period:g} Hz")
    z = np.exp(1j * TWO_PI * np.array(settings.lines) * law.period)
    cut = opened_at_samples(linear, Loop.of(scenario, law), z)
    closed = cut.plant @ cut.sensitivity
    at = [law.inputs.index(name) for name in feet]
    layout, valves = plant.obeying.central, np.eye(len(plant.mounts))[:, list(plant.layout.active)]
    spread, fit = valves @ volts(plant) @ layout.spread, layout.fit
    inverses = np.asarray(np.linalg.inv(fit @ closed[:, at] @ spread), complex)
    function = _LineLaw(law, settings, at, spread, np.asarray(inverses @ fit, complex))
    return PythonController(function, law.inputs, law.period, law.delay, **asdict(law.converter))


class _LineLaw:
    """The function that is called at each sample; it holds weights and the states of the law beside."""

    def __init__(
        self, law: Controller, settings: LineSettings, feet: list[int], spread: Array, inverses: ComplexArray
    ) -> None:
        self._law, self._feet, self._spread = law, feet, spread
        self._omega = TWO_PI * np.array(settings.lines)
        steps = 2.0 * law.period / settings.time
        self._steps = steps * inverses  # (lines, motion, feet): what the weights take of the feet's velocities
        self._keep = 1.0 - law.period / settings.leak
        self._windup = np.zeros(law.C.T.shape) if law.anti_windup is None else law.anti_windup
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self._state = np.zeros(self._law.states)
        self._weights = np.zeros((self._omega.size, self._spread.shape[1]), complex)

    def __call__(self, time: float, measured: Array, limited: Array) -> Array:
        law, turn = self._law, np.exp(1j * self._omega * time)
        self._state += self._windup @ limited
        wanted = law.C @ self._state + law.D @ measured + self._spread @ (turn @ self._weights).real
        self._state = law.A @ self._state + law.B @ measured
        self._weights *= self._keep
        # What the valves do not get has no answer: nothing is to be learnt from it.
        if not np.any(limited):
            self._weights -= turn.conj()[:, None] * (self._steps @ measured[self._feet])
        return np.asarray(wanted)


def _reading(law: Controller, feet: tuple[str, ...]) -> Controller:
    """The law with all feet among its inputs, whether it uses them or not."""
    more = tuple(name for name in feet if name not in law.inputs)
    wide: dict[str, Any] = {name: np.pad(getattr(law, name), ((0, 0), (0, len(more)))) for name in "BD"}
    return replace(law, inputs=law.inputs + more, **wide)

"""A control loop: a law with the instruments that it reads, and the loop that it makes with a machine by frequency.

Cut open at the valves together, the loop gain is L(jω) = −C(e^{jωT})·hold·delay·G(jω), (valve, valve), G from the
commands to the readings. Images of the machine around the sampling rate are left out: oil, valve and instruments let
nothing through there (1e-4 of the loop gain). `ehamj.linear.sampled.opened_at_samples` is exact, for laws of one rate.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self, overload

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.control.converter import check_mounts
from ehamj.control.linearisation import made_good
from ehamj.control.sensors import Sensors
from ehamj.control.spools import followed
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.plant.axes import CHAMBERS
from ehamj.plant.plant import Plant

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario


@dataclass(frozen=True, eq=False)
class Loop:
    """A law, the instruments that it reads, and the seed that draws the directions of their misalignments."""

    law: LinearController
    sensors: Sensors
    seed: int

    @overload
    @classmethod
    def of(cls, scenario: "Scenario", law: LinearController) -> Self: ...

    @overload
    @classmethod
    def of(cls, scenario: "Scenario", law: LinearController | None) -> Self | None: ...

    @classmethod
    def of(cls, scenario: "Scenario", law: LinearController | None) -> Self | None:
        """A law with a scenario's instruments and seed; None where there is no law."""
        if law is None:
            return None
        check_mounts(law.converter, scenario.plant.mounts)
        return cls(law, scenario.sensors, scenario.seed)

    def mixtures(self, channels: Sequence[str] | None = None) -> tuple[tuple[str, ...], Array]:
        """All channels that reach the instruments at some channels (without: the law's), and their shares in each."""
        return self.sensors.mixtures(self.law.inputs if channels is None else channels, self.seed)


def linear_under(plant: Plant, law: LinearController | None, commands: ArrayLike | None = None) -> LinearModel:
    """The machine linearised as a law has it: behind the stage that makes good what it knows of its valves,
    and the loops about their spools.

    Args:
        plant: what is linearised.
        law: that runs; None without.
        commands: as `linear_model`.

    Raises:
        InputError: as `linear_model`.
    """
    if law is not None:
        plant = made_good(followed(plant, law.converter.spools), law.converter.valves)
    return linear_model(plant, commands)


def closed_at_rest(model: LinearModel) -> tuple[str, ...]:
    """Mounts whose valves obey commands and pass nothing more for a small one, as within overlap, hysteresis or
    threshold: a law's loop is open there."""
    at = {name: k for k, name in enumerate(model.states)}

    def passes(mount: str) -> bool:
        moves = model.B[at[f"spool_rate {mount}"], model.commands.index(f"valve_command {mount}")] != 0.0
        feeds = model.A[[at[f"pressure_{chamber} {mount}"] for chamber in CHAMBERS], at[f"spool {mount}"]].any()
        return bool(moves and feeds)

    return tuple(mount for mount in model.plant.obeying.mounts if not passes(mount))


def own_readings(law: LinearController) -> list[int]:
    """Numbers of the law's inputs that measure the machine, and not the ground."""
    return [k for k, name in enumerate(law.inputs) if not name.startswith("ground_")]


def feeds_back(law: LinearController | None) -> bool:
    """Whether a law measures anything of the machine."""
    return law is not None and bool(own_readings(law))


@dataclass(frozen=True)
class Opened:
    """A loop cut open at the valves, at each frequency: what law and machine make of what comes to them.

    ``law`` (f, valve, reading) is the commands over the readings, ``plant`` (f, reading, valve) the readings over the
    commands; readings of the ground do not answer.
    """

    law: ComplexArray
    plant: ComplexArray

    @property
    def gain(self) -> ComplexArray:
        """L at the valves, (f, valve, valve): negative feedback, u = −L u."""
        return -self.law @ self.plant

    @property
    def sensitivity(self) -> ComplexArray:
        """S = (1 + L)⁻¹ at the valves, (f, valve, valve)."""
        return np.asarray(np.linalg.inv(np.eye(self.law.shape[1]) - self.law @ self.plant), complex)

    def commands(self, readings: ComplexArray) -> ComplexArray:
        """Commands of the closed loop over what moves the readings (f, reading, input), (f, valve, input)."""
        return np.asarray(np.linalg.solve(np.eye(self.law.shape[1]) - self.law @ self.plant, self.law @ readings))


def opened(model: LinearModel, loop: Loop, hertz: ArrayLike) -> Opened:
    """The loop cut open at frequencies (n,) below half the rate [Hz]; delay and hold count to the law."""
    f = np.atleast_1d(np.asarray(hertz, float))
    law, own = loop.law, own_readings(loop.law)
    plant = np.zeros((f.size, len(law.inputs), len(model.commands)), complex)
    if own:
        chosen = [law.inputs[k] for k in own]
        names, shares = loop.mixtures(chosen)
        answer = shares @ model.response(f, names, model.commands)
        plant[:, own] = loop.sensors.response(chosen, f)[:, :, None] * answer
    return Opened(law.response(f), plant)

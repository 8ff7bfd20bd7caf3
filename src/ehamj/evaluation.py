"""What a result says beyond its summary: linear machine, modes, transmissibilities; each computed once, when asked for.

Report, command line and whoever else shows a result read it here; results of one machine share what is the machine's.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from threading import RLock
from typing import Any, Final, Generic, TypeVar

import numpy as np
import xarray as xr

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.designs.footprint import rocking_modes, slowest_rocking
from ehamj.errors import InputError
from ehamj.linear.loop import Loop, feeds_back, linear_under
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.margins import grid, loop_gains
from ehamj.linear.modes import Mode, modes
from ehamj.linear.response import Transfer, machine_channels, rigid_floor
from ehamj.result import Result
from ehamj.rig.comparison import own_output, runs_unknown_law
from ehamj.rig.measurement import Measurement
from ehamj.rig.welch import by_welch
from ehamj.scenario.model import Scenario

DIRECTIONS: Final = ("z", "x", "y", "rx", "ry", "rz")
"""Degrees of freedom of the floor whose transmissibility a run shows."""
FREQUENCIES: Final = np.geomspace(1.0, 315.0, 300)
"""At which linear responses are computed [Hz]."""
USABLE: Final = 0.4
"""Share of the recording rate up to which a run's own transmissibility is shown."""

DESIGNS: Final = 25
"""Designs of the map of rocking each way."""
HEIGHTS: Final = (0.25, 2.5)
"""Range of the map's CG heights, over the machine's own [-]."""
LEAST_HEIGHT: Final = 0.2
"""CG height that the range is taken of at least [m]: that of a machine may be zero."""
WIDTHS: Final = (0.4, 1.8)
"""Range of the map's footprints, over the machine's own [-]."""

T = TypeVar("T")


class Once(Generic[T]):
    """A property that is computed when it is first asked for, by one thread: its owner has a ``lock``."""

    def __init__(self, compute: Callable[[Any], T]) -> None:
        self.compute, self.__doc__ = compute, compute.__doc__

    def __get__(self, owner: Any, kind: type | None = None) -> T:
        name, known = self.compute.__name__, vars(owner)  # what stands in there is found before this descriptor
        with owner.lock:
            if name not in known:
                known[name] = self.compute(owner)
            found: T = known[name]
        return found


class Machine:
    """The linear machine of a scenario, with its valves held; None where it has no rest to linearise about."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.lock = scenario, RLock()

    @Once
    def model(self) -> LinearModel | None:
        """Linear about its equilibrium."""
        with suppress(InputError):  # under a load that is held there is none
            return linear_model(self.scenario.plant)
        return None

    @Once
    def modes(self) -> Sequence[Mode]:
        """Modes with the valves held."""
        return modes(self.model) if self.model else ()

    @Once
    def transfer(self) -> Transfer | None:
        """Rigid floor to machine at `FREQUENCIES`, valves held."""
        return rigid_floor(self.model, FREQUENCIES) if self.model else None

    @Once
    def rocking(self) -> xr.Dataset | None:
        """Slowest sway-rocking over CG height and footprint: ``slowest`` [Hz], ``tipping_margin`` [-], over ``height``
        [m] and ``width``, a factor on the mounts' places.

        None for machines whose linear model has no closed form (`ehamj.designs.designs.Designs`).
        """
        heights = np.linspace(*HEIGHTS, DESIGNS) * max(self.scenario.machine.cg[2], LEAST_HEIGHT)
        widths = np.linspace(*WIDTHS, DESIGNS)
        with suppress(InputError):
            found = rocking_modes(
                self.scenario, xr.DataArray(heights, dims="height"), xr.DataArray(widths, dims="width")
            )
            over = xr.Dataset({"slowest": slowest_rocking(found), "tipping_margin": found["tipping_margin"]})
            return over.assign_coords(height=heights, width=widths).transpose("height", "width")
        return None


class Evaluation:
    """What a result says beyond its summary."""

    def __init__(self, result: Result, machine: Machine | None = None) -> None:
        self.result, self.lock = result, RLock()
        self.machine = machine or Machine(result.scenario)

    @property
    def law(self) -> LinearController | None:
        """The law that ran, as far as it is known."""
        return self.result.controller

    @Once
    def model(self) -> LinearModel | None:
        """The linear machine as the law has it, behind the linearisation of its valves and the loops about their
        spools."""
        if self.law is None or not (self.law.converter.valves or self.law.converter.spools):
            return self.machine.model
        with suppress(InputError):
            return linear_under(self.result.scenario.plant, self.law)
        return None

    @Once
    def modes(self) -> Sequence[Mode] | None:
        """Modes of the closed loop; None where the law measures nothing of the machine."""
        model = self.model
        if model is None or not feeds_back(self.law):
            return None
        return modes(model, Loop.of(self.result.scenario, self.law))

    @Once
    def loop_gains(self) -> tuple[Array, Mapping[str, ComplexArray]] | None:
        """Frequencies [Hz] and the loop gain of each motion with the others closed; None as `modes`."""
        model = self.model
        if model is None or self.law is None or not feeds_back(self.law):
            return None
        hertz = grid(self.law, model, dense=3)
        return hertz, loop_gains(model, Loop.of(self.result.scenario, self.law), hertz)

    @Once
    def transfer(self) -> Transfer | None:
        """Rigid floor to machine at `FREQUENCIES` as controlled; None where machine or law are not known."""
        model, loop = self.model, Loop.of(self.result.scenario, self.law)
        if model is None or runs_unknown_law(self.result):
            return None
        return self.machine.transfer if loop is None else rigid_floor(model, FREQUENCIES, loop)

    @Once
    def measured(self) -> Mapping[str, Measurement]:
        """Rigid floor to machine measured from the run by Welch's method, by degree of freedom that moves; nothing of a
        run that is too short."""
        outputs, found = machine_channels(), {}
        usable = self.result.summary.analysis.usable_to_hz or math.inf
        last = min(float(FREQUENCIES[-1]), usable, USABLE * self.result.scenario.record_rate)
        with suppress(InputError):
            for one in by_welch(self.result, [([own_output(outputs, dof)], [dof]) for dof in DIRECTIONS]):
                within = one.within(float(FREQUENCIES[0]), last)
                if np.isfinite(within.estimate.response).any():
                    found[one.inputs[0]] = within
        return found


def evaluate(results: Mapping[str, Result]) -> dict[str, Evaluation]:
    """Evaluations of results by label; those of one machine share it."""
    found: dict[str, Evaluation] = {}
    for label, result in results.items():
        alike = (one.machine for one in found.values() if one.machine.scenario.plant == result.scenario.plant)
        found[label] = Evaluation(result, next(alike, None))
    return found

"""Merits of the closed loop: margins, stability, attenuation, and what the floor asks of valves and supply."""

import threading
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.control import LinearController
from ehamj.control.linearisation import made_good
from ehamj.control.settings import DigitalSettings
from ehamj.control.spools import followed
from ehamj.designs.loops import HeldLoop
from ehamj.designs.many import held_poles
from ehamj.designs.stack import Stack
from ehamj.errors import InputError
from ehamj.judge.levels import BANDS
from ehamj.linear.loop import Loop, feeds_back, linear_under, own_readings
from ehamj.linear.machine import LinearModel
from ehamj.linear.margins import report
from ehamj.linear.response import commanded, ground_response, machine_channels, readings_of_ground
from ehamj.linear.sampled import STABLE, sampled_loop, spectral_radius
from ehamj.linear.unstable import GROWS
from ehamj.linear.values import Values
from ehamj.merits.floor import FloorSpectrum
from ehamj.merits.merit import SOURCES, Failed, Machine, Merit
from ehamj.merits.passive import NO_REST
from ehamj.merits.stacked import LinearSource, Row, Stacked, attenuations, hertz_of
from ehamj.plant.axes import AXES
from ehamj.scenario.model import Scenario

MARGINS: Final = (
    ("gain_margin", "dB", "gain margin"),
    ("phase_margin", "deg", "phase margin"),
    ("disk_margin", "1", "balanced disk margin"),
)
FLOOR: Final = ("voltage", "flow", "power")
KEPT: Final = 4
"""Machines whose laws are kept."""


class HeldMachine:
    """A machine with its law, which is derived once, and what designs of it share."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self._last: tuple[Scenario, LinearController | None] | None = None

    @cached_property
    def law(self) -> LinearController | None:
        """Its digital law; None where it has none."""
        return self.scenario.controller()

    @cached_property
    def loop(self) -> HeldLoop:
        """The law around designs."""
        assert self.law is not None
        return HeldLoop(self.scenario, self.law)

    @cached_property
    def growing(self) -> int | None:
        """How many poles of the sampled loop grow; None where the machine itself has one that does."""
        assert self.law is not None
        model = linear_under(self.scenario.plant, self.law)
        if np.linalg.eigvals(model.A).real.max() > GROWS:
            return None
        values = np.linalg.eigvals(sampled_loop(model, Loop.of(self.scenario, self.law)).A)
        return int((np.abs(values) >= STABLE).sum())

    @cached_property
    def floor(self) -> FloorSpectrum:
        """What the floor does."""
        assert self.law is not None
        return FloorSpectrum.of(self.scenario, _highest(self.law))

    def law_of(self, scenario: Scenario) -> LinearController | None:
        """The law of one design: this one, or the last one, where it is held for the same machine."""
        if _same_law(scenario, self.scenario):
            return self.law
        last = self._last
        if last is None or not _same_law(scenario, last[0]):
            self._last = last = (scenario, scenario.controller())
        return last[1]

    def floor_of(self, scenario: Scenario, law: LinearController) -> FloorSpectrum:
        """The floor of one design: this one, but where the design has another. Where its mounts stand does not
        count."""
        what = ("ground", "duration", "seed")
        if all(getattr(scenario, name) == getattr(self.scenario, name) for name in what) and self.law is not None:
            return self.floor
        return FloorSpectrum.of(scenario, _highest(law))


def _same_law(one: Scenario, other: Scenario) -> bool:
    """Whether two scenarios have one law: the same settings, derived from the same machine."""
    ours, theirs = one.control, other.control
    if not isinstance(ours, DigitalSettings) or not isinstance(theirs, DigitalSettings):
        return False
    return theirs.model_copy(update={"designed_for": ours.designed_for}) == ours and one.nominal == other.nominal


def _highest(law: LinearController) -> float:
    """Frequency up to which a floor is looked at [Hz]: short of half the slowest rate."""
    return 0.45 / max(part.period for part in law.parts)


class LoopSource(LinearSource):
    """Merits of the closed loop of a digital law.

    Margins and disk margins are those of `ehamj.linear.margins.report`: the least over valves, patterns of them and
    readings, or at one place with the rest closed; ``stable`` by the eigenvalues of the sampled loop, or the turns of
    det(1 + L) against those of the scenario's own, where they are plain. Attenuation is that of a floor that moves as
    one slab, with the same velocity at `PER_BAND` frequencies in each band. Voltage and flow are root mean squares over
    the scenario's floor (its spectrum over the run's time), the flow drawn is the mean that normally distributed
    openings draw, leakage over the edges with it, and the power that flow over the supply's pressure; no limit and no
    noise plays a part, and the floor's wave meets the mounts where the scenario has them.

    A law that is held is known over frequency once, and all designs are computed at once in closed form
    (`ehamj.designs.loops`). One that is derived anew for each design, and machines without closed forms, are computed
    one at a time.
    """

    whole = True

    def __init__(self) -> None:
        self._machines: list[HeldMachine] = []
        self._lock = threading.Lock()

    def held(self, scenario: Scenario) -> HeldMachine:
        """A scenario with its law, made once."""
        with self._lock:
            found = next((one for one in self._machines if one.scenario is scenario), None)
            if found is None:
                found = next((one for one in self._machines if one.scenario == scenario), None)
            if found is None:
                found = HeldMachine(scenario)
                self._machines = [found, *self._machines[: KEPT - 1]]
            return found

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        if not isinstance(machine.scenario.control, DigitalSettings):
            return {}
        law = self.held(machine.scenario).law
        return {one.name: one for one in _merits(machine.scenario, law)} if law is not None else {}

    def opens(self, machine: Machine) -> str | None:
        if machine.law == "derived":
            return "the law is derived anew for each design"
        why = super().opens(machine)
        law = self.held(machine.scenario).law
        if why is None and law is not None:
            plant = machine.scenario.plant
            if made_good(followed(plant, law.converter.spools), law.converter.valves) != plant:
                return "the law makes good what its valves have, or closes loops about their spools"
        return why

    def together(self, stacked: Stacked, names: Sequence[str]) -> list[Row]:
        own = self.held(stacked.machine.scenario)
        stack, count = Stack.of(stacked.designs.values), stacked.count
        found: dict[str, Array] = {}
        if _asked_margins(names):
            poles = held_poles(stack.elements, stack.rest, stack.empty)
            margins = own.loop.margins(stack, poles, count)
            found |= _margin_columns(own.loop.places, margins.places, margins.disk)
            if "loop.stable" in names:
                doubtful = margins.doubtful | (poles.real.max(axis=1)[:count] > GROWS) | (own.growing is None)
                stable = margins.grown + (own.growing or 0) <= 0
                for k in np.flatnonzero(doubtful & ~stack.empty[:count]):
                    stable[k] = self._is_stable(own, stacked.scenario(int(k)))
                found["stable"] = stable.astype(float)
        if _asked(names, "attenuation", "peak", *FLOOR):
            found |= _floor_columns(own, stack, count, _asked(names, *FLOOR))
        columns = {name: found[name.partition(".")[2]] for name in names}
        return [
            Failed(NO_REST) if stack.empty[k] else {name: float(column[k]) for name, column in columns.items()}
            for k in range(count)
        ]

    def _is_stable(self, own: HeldMachine, scenario: Scenario) -> bool:
        law = own.law_of(scenario)
        model = linear_under(scenario.plant, law)
        loop = Loop.of(scenario, law)
        assert loop is not None
        return spectral_radius(model, loop) < STABLE

    def alone(self, machine: Machine, scenario: Scenario, names: Sequence[str]) -> Row:
        own = self.held(machine.scenario)
        law = own.law_of(scenario)
        if law is None:
            raise InputError("control: merits of the loop need a digital law")
        model, loop = linear_under(scenario.plant, law), Loop.of(scenario, law)
        found: dict[str, Array] = {}
        if _asked_margins(names):
            told = report(model, loop)
            places = [*told.valves.values(), *told.motions.values(), *told.readings.values()]
            levels = np.array([[[one.gain, one.phase, one.disk] for one in places]])
            found |= _margin_columns(_places(scenario, law), levels, np.array([told.disk]))
            found["stable"] = np.array([float(told.stable)])
        if _asked(names, "attenuation", "peak", *FLOOR):
            floor = own.floor_of(scenario, law) if _asked(names, *FLOOR) else None
            found |= _floor_alone(scenario, model, loop, floor)
        return {name: float(found[name.partition(".")[2]][0]) for name in names}


def _asked(names: Sequence[str], *kinds: str) -> bool:
    return any(name.split(".")[1] in kinds for name in names)


def _asked_margins(names: Sequence[str]) -> bool:
    return _asked(names, "stable", "disk_margin_all_valves", *(name for name, _, _ in MARGINS))


def _places(scenario: Scenario, law: LinearController) -> tuple[str, ...]:
    """Places where the loop can be broken, as `ehamj.designs.loops.HeldLoop.places`."""
    valves = (f"valve {name}" for name in scenario.plant.obeying.mounts)
    return (*valves, *scenario.plant.central.patterns, *(f"reading {law.inputs[k]}" for k in own_readings(law)))


def _margin_columns(places: Sequence[str], levels: Array, disk: Array) -> dict[str, Array]:
    """Margins by name, from those per place (design, place, 3) and of all valves at once (design,)."""
    found, worst = {"disk_margin_all_valves": disk}, levels.min(axis=1)
    worst[:, 2] = np.minimum(worst[:, 2], disk)
    for k, (name, _, _) in enumerate(MARGINS):
        found[name] = worst[:, k]
        found |= {f"{name}.{_word(place)}": levels[:, number, k] for number, place in enumerate(places)}
    return found


def _word(place: str) -> str:
    return place.replace(" ", "-")


def _floor_columns(own: HeldMachine, stack: Stack, count: int, floor: bool) -> dict[str, Array]:
    """What depends on the floor, by name, of the first designs of a stack."""
    mounts = len(own.scenario.plant.mounts)
    assert own.law is not None
    hertz, ground = _ground(own.floor if floor else None, mounts, _highest(own.law))
    moved, commands = own.loop.floor(stack, hertz, ground, count)
    found = _slab_columns(hertz, np.einsum("dfaa->dfa", moved[..., : len(AXES)]))
    if floor:
        values = stack.elements.values
        found |= _supply_columns(hertz, commands[..., len(AXES) :], values, stack.oil[:count])
    return found


def _ground(floor: FloorSpectrum | None, mounts: int, highest: float) -> tuple[Array, ComplexArray]:
    """Frequencies, of bands below the ``highest`` [Hz], and columns: a slab along x, y, z; then those of the floor."""
    slab = np.tile(np.eye(len(AXES), dtype=complex), (1, mounts, 1, 1))
    if floor is None:
        return hertz_of([band for band in BANDS if band.edges[1] < highest]), slab
    slabs = np.broadcast_to(slab, (floor.hertz.size, *slab.shape[1:]))
    return floor.hertz, np.concatenate([slabs, floor.columns], axis=-1)


def _slab_columns(hertz: Array, moved: ComplexArray) -> dict[str, Array]:
    """Attenuation and peak from the motion over that of a slab, (design, f, axis); NaN in bands that are not there."""
    first, found = int(np.argmin(np.abs(hertz - hertz_of(BANDS)[0]))), {}
    squares = np.abs(moved[:, first : first + len(hertz_of(BANDS))]) ** 2
    levels, known = np.full((len(squares), len(BANDS), len(AXES)), np.nan), attenuations(squares)
    levels[:, : known.shape[1]] = known
    for k, axis in enumerate(AXES):
        found[f"peak.{axis}"] = 10.0 * np.log10(squares[..., k].max(axis=1))
        found |= {f"attenuation.{axis}.{band.name}": levels[:, b, k] for b, band in enumerate(BANDS)}
    return found


def _supply_columns(hertz: Array, commands: ComplexArray, values: Values, oil: Array) -> dict[str, Array]:
    """Voltage, flow and power from the commands (design, f, mount, column); ``oil`` as `Stack.oil`."""
    s = 2j * np.pi * hertz[:, None]
    edge, flow_gain, gain, frequency, damping = (oil[:, None, :, k] for k in (5, 7, 8, 9, 10))
    spools = gain * frequency**2 / (s**2 + 2.0 * damping * frequency * s + frequency**2)
    squares = (np.abs(commands) ** 2).sum(axis=-1)
    voltage = np.sqrt(squares.sum(axis=1))
    flow = np.sqrt((squares * np.abs(flow_gain * spools) ** 2).sum(axis=1))
    common = {name: np.broadcast_to(values.common[name], values.common["mass"].shape).reshape(-1)[: len(oil)]
              for name in ("pressure", "tank_pressure")}  # fmt: skip
    drop = common["pressure"] - common["tank_pressure"]
    drawn = np.sqrt(2.0 / np.pi) * flow.sum(axis=1) + edge[:, 0].sum(axis=1) * drop  # 2 g₀ (P_s − P_t)/2 each
    return {
        "voltage.rms": voltage.max(axis=1), "flow.rms": flow.max(axis=1), "flow.drawn": drawn, "power": drop * drawn,
    }  # fmt: skip


def _floor_alone(scenario: Scenario, model: LinearModel, loop: Loop, floor: FloorSpectrum | None) -> dict[str, Array]:
    hertz, ground = _ground(floor, len(scenario.plant.mounts), _highest(loop.law))
    flat = np.broadcast_to(ground, (hertz.size, *ground.shape[1:])).reshape(hertz.size, -1, ground.shape[-1])
    moved = ground_response(model, hertz, machine_channels()[: len(AXES)], loop) @ flat[..., : len(AXES)]
    found = _slab_columns(hertz, np.einsum("faa->fa", moved)[None])
    if floor is not None:
        readings = readings_of_ground(model, loop, hertz) @ flat[..., len(AXES) :]
        values = Values.of(model.plant)
        found |= _supply_columns(hertz, commanded(model, loop, hertz, readings)[None], values, Stack.of(values).oil)
    return found


def _merits(scenario: Scenario, law: LinearController) -> list[Merit]:
    found = []
    if feeds_back(law):
        found.append(Merit("loop.stable", "1", "1 where the closed loop is stable, 0 where it is not"))
        found.append(Merit("loop.disk_margin_all_valves", "1", "balanced disk margin of all valves at once"))
        for name, unit, text in MARGINS:
            found.append(Merit(f"loop.{name}", unit, f"{text}, the least there is"))
            for place in _places(scenario, law):
                found.append(Merit(f"loop.{name}.{_word(place)}", unit, f"{text} at {place}, the rest closed"))
    for axis in AXES:
        text = f"largest motion along {axis} of the centre of gravity over that of the floor, as one slab"
        found.append(Merit(f"loop.peak.{axis}", "dB", text))
        for band in BANDS:
            text = f"floor over centre of gravity along {axis} in the third-octave band at {band.name} Hz, as one slab"
            found.append(Merit(f"loop.attenuation.{axis}.{band.name}", "dB", text))
    found.append(Merit("loop.voltage.rms", "V", "RMS command over the scenario's floor, of the valve with the most"))
    found.append(Merit("loop.flow.rms", "m³/s", "RMS flow of a valve over the scenario's floor, the largest"))
    found.append(Merit("loop.flow.drawn", "m³/s", "mean flow drawn from the supply by all valves"))
    found.append(Merit("loop.power", "W", "mean hydraulic power drawn from the supply"))
    return found


SOURCES.add("loop", LoopSource())

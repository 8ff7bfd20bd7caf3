"""What sources of linear merits share: which designs have closed forms, and stacks of fixed size of them."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.designs.designs import Designs
from ehamj.designs.parameters import check, mount_of, quantity_of
from ehamj.errors import InputError
from ehamj.estimate.bands import Band
from ehamj.judge.levels import BANDS
from ehamj.merits.applied import designs_of, scenario_of
from ehamj.merits.merit import Design, Failed, Found, Machine, Source
from ehamj.scenario.model import Scenario

PER_BAND: Final = 8
"""Frequencies in each third-octave band."""

OF_MACHINES: Final = ("machine", "mount", "actuators", "supply", "gravity", "footprint", "part", "slide")
"""First words of keys that change a machine; all others leave its own linear figures as they are."""

RATED: Final = ("rated_flow", "rated_drop", "spool_stroke", "flow_gain")
"""Values of an actuator that have to do with its flow gain where it is stated by rated-flow data."""


@dataclass(frozen=True)
class Stacked:
    """One stack: ``designs``, of which the first ``count`` were asked for, and their values; the others fill it."""

    machine: Machine
    designs: Designs
    values: Sequence[Mapping[str, Any]]
    count: int

    def scenario(self, number: int) -> Scenario:
        """One of them by itself."""
        return scenario_of(self.machine, self.values[number])


Row = Mapping[str, float] | Failed


def hertz_of(bands: Sequence[Band]) -> Array:
    """Frequencies in the middle of equal logarithmic parts of bands, `PER_BAND` each [Hz]."""
    edges = np.array([band.edges for band in bands])
    shares = (np.arange(PER_BAND) + 0.5) / PER_BAND
    return np.asarray((edges[:, :1] * (edges[:, 1:] / edges[:, :1]) ** shares).ravel())


def attenuations(squares: Array) -> Array:
    """Attenuation per band [dB] from |T|² at `hertz_of` `BANDS` along the last axis but one, (…, f, axis): a floor that
    moves with the same velocity at each of the frequencies over the machine (`ehamj.estimate.bands`)."""
    split = squares.reshape(*squares.shape[:-2], len(BANDS), PER_BAND, squares.shape[-1])
    with np.errstate(divide="ignore"):
        return np.asarray(-10.0 * np.log10(split.mean(axis=-2)))


class LinearSource(Source):
    """A source of linear merits: all designs that have closed forms at once, the others one at a time."""

    block = 256
    whole = False
    """Whether the control, instruments and floor count too, and not the machine alone."""

    @abstractmethod
    def together(self, stacked: Stacked, names: Sequence[str]) -> list[Row]:
        """Merits of each design of a stack; what fills it may be left out."""

    @abstractmethod
    def alone(self, machine: Machine, scenario: Scenario, names: Sequence[str]) -> Row:
        """Merits of one design of a machine, whose scenario is given.

        Raises:
            InputError: if it is impossible.
        """

    def opens(self, machine: Machine) -> str | None:
        """Why designs of a machine have to be computed one at a time; None where they have closed forms."""
        try:
            Designs.of(machine.scenario, {})
        except InputError as error:
            return str(error)
        return None

    def notes(self, machine: Machine) -> list[str]:
        """Whether it computes designs one at a time."""
        why = self.opens(machine)
        return [] if why is None else [f"computed one design at a time from the differentiated model: {why}"]

    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        found: list[Found] = [Failed("not computed")] * len(designs)
        stacks: dict[tuple[str, ...], list[tuple[int, Mapping[str, Any]]]] = {}
        closed = self.opens(machine) is None
        for k, design in enumerate(designs):
            values = {key: value for key, value in design.values.items() if self.whole or _moves(key)}
            if not closed or not _has_closed_forms(machine.scenario, values):
                found[k] = self._by_itself(machine, values, design.known, names)
            elif (why := _impossible(machine.scenario, values)) is not None:
                found[k] = Failed(why)
            else:
                stacks.setdefault(tuple(values), []).append((k, values))
        for own in stacks.values():
            rows = self._stack(machine, [values for _, values in own], names)
            for (k, _), row in zip(own, rows, strict=True):
                found[k] = row
        return found

    def _stack(self, machine: Machine, values: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[Row]:
        """Stacks have one size, so that a design comes out the same to the bit in any company."""
        filled = [*values, *[values[0]] * (self.block - len(values))]
        try:
            rows = self.together(Stacked(machine, designs_of(machine, filled), filled, len(values)), names)
        except np.linalg.LinAlgError as error:  # of one of them
            if len(values) == 1:
                return [Failed(f"no linear model: {error}")]
            return [self._stack(machine, [one], names)[0] for one in values]
        return list(rows[: len(values)])

    def _by_itself(
        self, machine: Machine, values: Mapping[str, Any], known: Mapping[str, Any] | None, names: Sequence[str]
    ) -> Row:
        return tried(lambda: self.alone(machine, scenario_of(machine, values, known if self.whole else None), names))


def tried(compute: Callable[[], Row]) -> Row:
    """What a design comes out with, or why it does not."""
    try:
        return compute()
    except InputError as error:
        return Failed(" ".join(str(error).split()))
    except np.linalg.LinAlgError as error:
        return Failed(f"no linear model: {error}")


def _moves(key: str) -> bool:
    return key.partition(".")[0] in OF_MACHINES


def _has_closed_forms(scenario: Scenario, values: Mapping[str, Any]) -> bool:
    """Whether these values are numbers of what closed forms vary."""
    rated = any(actuator.rated_flow for actuator in scenario.actuators.values())
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            return False
        try:
            quantity_of(scenario, key)
        except InputError:
            return False
        if key.endswith(RATED[:1]) or (rated and (key.startswith("supply.") or key.endswith(RATED))):
            return False  # the flow gain would follow
    return True


def _impossible(scenario: Scenario, values: Mapping[str, Any]) -> str | None:
    """Why a design cannot be, in one line."""
    try:
        for key, value in values.items():
            check(scenario, key, np.array([value], float))
            if key.endswith("foot_stiffness"):
                own = scenario.actuators[_actuator_of(scenario, key)]
                if np.isinf(value) != own.rigid_foot:
                    raise InputError(f"{key} = {value:g}: must be finite in all designs, or infinite in all")
    except InputError as error:
        return str(error).removeprefix("vary: ")
    high, low = (
        float(values.get(f"supply.{name}", getattr(scenario.supply, name))) for name in ("pressure", "tank_pressure")
    )
    return None if high > low else f"supply.pressure = {high:g} Pa must be above tank_pressure = {low:g} Pa"


def _actuator_of(scenario: Scenario, key: str) -> str:
    number, _ = mount_of(scenario, key)
    return key.split(".")[1] if number is None else scenario.mount[number].actuator

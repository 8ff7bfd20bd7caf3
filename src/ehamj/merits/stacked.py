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
from ehamj.merits.applied import designs_of, scenario_of
from ehamj.merits.merit import Design, Failed, Found, Machine, Source
from ehamj.scenario.model import Scenario

PER_BAND: Final = 8
"""Frequencies in each third-octave band."""

OF_MACHINES: Final = ("machine", "mount", "actuators", "supply", "gravity", "footprint", "part", "slide")
"""First words of keys that change a machine; all others leave its own linear figures as they are."""

FITTED: Final = ("footprint.", "machine.cg", "machine.inertia")
"""Keys of values that must fit the machine's outline, or each other, as positions of mounts must."""
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
    """Attenuation per band [dB] from |T|² at `hertz_of` bands along the last axis but one, (…, f, axis): a floor that
    moves with the same velocity at each of the frequencies over the machine (`ehamj.estimate.bands`)."""
    split = squares.reshape(*squares.shape[:-2], -1, PER_BAND, squares.shape[-1])
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
        closed, known = self.opens(machine) is None, _Keys(machine.scenario)
        for k, design in enumerate(designs):
            values = {key: value for key, value in design.values.items() if self.whole or _moves(key)}
            if closed and all(known.varied(key) and _is_number(value) for key, value in values.items()):
                stacks.setdefault(tuple(values), []).append((k, values))
            else:
                found[k] = self._by_itself(machine, values, design.known, names)
        for own in stacks.values():
            why = known.impossible([values for _, values in own])
            good = [one for one, reason in zip(own, why, strict=True) if reason is None]
            rows = self._stack(machine, [values for _, values in good], names) if good else []
            for (k, _), row in zip(good, rows, strict=True):
                found[k] = row
            for (k, _), reason in zip(own, why, strict=True):
                if reason is not None:
                    found[k] = Failed(reason)
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


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


class _Keys:
    """What is known of the keys that designs of a scenario differ in, looked up once for all designs."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self._rated = any(actuator.rated_flow for actuator in scenario.actuators.values())
        self._varied: dict[str, bool] = {}

    def varied(self, key: str) -> bool:
        """Whether closed forms vary it."""
        if key not in self._varied:
            self._varied[key] = self._is_varied(key)
        return self._varied[key]

    def _is_varied(self, key: str) -> bool:
        if key.endswith(RATED[:1]) or (self._rated and (key.startswith("supply.") or key.endswith(RATED))):
            return False  # the flow gain would follow
        try:
            quantity_of(self.scenario, key)
        except InputError:
            return False
        return True

    def impossible(self, designs: Sequence[Mapping[str, Any]]) -> list[str | None]:
        """Why each of some designs, which have the same keys, cannot be, in one line; None where it can."""
        found: list[str | None] = [None] * len(designs)
        for key in designs[0]:
            values = np.array([one[key] for one in designs], float)
            if self._refused(key, values) is not None:
                for k, value in enumerate(values):
                    found[k] = found[k] or self._refused(key, np.array([value]))
        low, high = (self._of_supply(designs, name) for name in ("tank_pressure", "pressure"))
        for k in np.flatnonzero(~(high > low)).tolist():
            said = f"supply.pressure = {high[k]:g} Pa must be above tank_pressure = {low[k]:g} Pa"
            found[k] = found[k] or said
        if any(key.startswith(FITTED) or ".position." in key for key in designs[0]):
            for k, one in enumerate(designs):
                found[k] = found[k] or self._unfit(one)
        return found

    def _unfit(self, values: Mapping[str, Any]) -> str | None:
        """Why values that must fit each other make no machine, which its scenario says."""
        try:
            scenario_of(Machine(self.scenario), values)
        except InputError as error:
            return " ".join(str(error).split())
        return None

    def _refused(self, key: str, values: Array) -> str | None:
        try:
            check(self.scenario, key, values)
        except InputError as error:
            return str(error).removeprefix("vary: ")
        if key.endswith("foot_stiffness"):
            number, _ = mount_of(self.scenario, key)
            kind = key.split(".")[1] if number is None else self.scenario.mount[number].actuator
            other = values[np.isinf(values) != self.scenario.actuators[kind].rigid_foot]
            if other.size:
                return f"{key} = {other[0]:g}: must be finite in all designs, or infinite in all"
        return None

    def _of_supply(self, designs: Sequence[Mapping[str, Any]], name: str) -> Array:
        own = getattr(self.scenario.supply, name)
        return np.array([one.get(f"supply.{name}", own) for one in designs], float)

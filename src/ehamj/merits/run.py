"""Figures of merit from nonlinear runs, of either engine: ``run.`` and the keys of a number in ``summary.json``.

Designs of equal structure step side by side in lanes of the small-motion engine.
"""

import threading
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, Final, get_args, get_origin

from ehamj.criteria.vc import CLASSES
from ehamj.errors import InputError, SimulationFailed
from ehamj.findings import Finding
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, Merit, Source
from ehamj.merits.undecided import undecided
from ehamj.plant.axes import AXES
from ehamj.run.failures import Incomplete
from ehamj.run.figures import Path, figures
from ehamj.run.side_by_side import LANES
from ehamj.run.simulate import simulate
from ehamj.run.together import Item, Ran, Refused, Shared, together
from ehamj.scenario.load import files_of
from ehamj.scenario.model import Scenario
from ehamj.variables import VARIABLES

FIRST: Final = "run"
"""First word of the names."""
ROWS: Final = 40
"""Recorded rows of the short run that shows what there is."""
CHANCE: Final = (("timing", "wall_s"), ("timing", "stepping_s"), ("timing", "ratio"), ("law", "seconds"))
"""Numbers that are others in every run of the same."""
UNITS: Final = {
    "_m3_s": "m³/s",
    "_1_s": "1/s",
    "_db": "dB",
    "_deg": "deg",
    "_hz": "Hz",
    "_kg": "kg",
    "_m3": "m³",
    "_m": "m",
    "_w": "W",
    "_s": "s",
}
"""Unit by how a key ends."""
QUANTITIES: Final = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s²"}
BESIDE: Final[Mapping[Path, Merit]] = {
    ("flow", "rms"): Merit("run.flow.rms", "m³/s", "RMS of the oil that all valves together pass"),
    ("flow", "peak"): Merit("run.flow.peak", "m³/s", "most oil that all valves together pass"),
    ("power",): Merit("run.power", "W", "mean hydraulic power drawn from the supply"),
    **{
        ("below", name, axis): Merit(
            f"run.below.{name.replace(' ', '-')}.{axis}",
            "dB",
            f"by how much the machine's worst place stays below {name} along {axis}, in the band that comes nearest",
        )
        for name in CLASSES
        for axis in AXES
    },
}
"""What a summary does not have."""


class Runs(Source):
    """Numbers of the summaries of designs' runs."""

    block: ClassVar[int] = LANES

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: _Numbers | None = None

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        """One for each number in the summary of the machine's own run; those of lists are left out, and those in bands
        that runs are too short for.

        Raises:
            InputError: if the machine cannot be run as it is.
        """
        return self._numbers(machine).merits

    def why_not(self, machine: Machine, name: str) -> str:
        """Of a number in a band that runs are too short for."""
        path = self._numbers(machine).paths.get(name)
        return undecided(machine.scenario, path) if path else ""

    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        """Each design is run, those of equal structure side by side, on the thread of the caller."""
        paths = {name: self._numbers(machine).paths[name] for name in names}
        wanted = tuple(paths.values())

        def items() -> Iterator[Item | Refused]:
            for number, design in enumerate(designs):
                try:
                    scenario = scenario_of(machine, design.values, design.known)
                except Exception as error:
                    yield Refused(number, error)
                else:
                    yield Item(number, scenario)

        def found(ran: Ran) -> Found:
            numbers = figures(ran.prepared, ran.driven, wanted)
            return {name: numbers[path] for name, path in paths.items()}

        shared = self._numbers(machine).shared
        return together(items(), found, 0, len(designs), on_failure=_failed, held=False, shared=shared)

    def _numbers(self, machine: Machine) -> "_Numbers":
        """What the machine's summary holds; that of the last machine is kept."""
        with self._lock:
            if self._last is None or (
                self._last.scenario is not machine.scenario and self._last.scenario != machine.scenario
            ):
                self._last = _Numbers(machine.scenario)
            return self._last


class _Numbers:
    """What numbers there are in the summary of a scenario's run."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario

    @cached_property
    def shared(self) -> Shared | None:
        """What all designs' runs have in common; None where a file is read, which may change."""
        return None if files_of(self.scenario) else Shared.lasting()

    @cached_property
    def paths(self) -> dict[str, Path]:
        """Keys that lead to each, by its merit's name."""
        short = min(self.scenario.duration, ROWS / self.scenario.record_rate)
        try:
            summary = simulate(self.scenario.model_copy(update={"duration": short, "compare": ()})).summary
        except Incomplete as error:  # its designs may hold
            summary = error.result.summary
        found = [path for path in _leaves(type(summary), summary) if path not in CHANCE and not _of_norm(path)]
        return {one.name: path for path, one in BESIDE.items()} | {".".join((FIRST, *path)): path for path in found}

    @cached_property
    def merits(self) -> dict[str, Merit]:
        """All of them that runs can have."""
        return {
            name: BESIDE.get(path) or Merit(name, _unit(path), f"{' → '.join(path)} in the run's summary")
            for name, path in self.paths.items()
            if not undecided(self.scenario, path)
        }


def _of_norm(path: Path) -> bool:
    """Whether a number is a level of a norm, whose unit is that of whatever decided."""
    return path[0] in ("criterion", "criteria") and path[-1] in ("level", "limit", "peak")


def _failed(_: int, error: Exception) -> Failed:
    said = isinstance(error, InputError | SimulationFailed)
    return Failed(str(error) if said else f"{type(error).__name__}: {error}")


def _leaves(kind: Any, value: Any) -> Iterator[Path]:
    """Keys that lead to numbers, and to where a number may be, of what is annotated as ``kind``."""
    kinds = list(_alternatives(kind))
    table = next((one for one in kinds if isinstance(one, type) and issubclass(one, Finding)), None)
    if isinstance(value, Finding) or (value is None and table is not None):
        model = table if value is None else type(value)
        assert model is not None
        for name, field in model.model_fields.items():
            for rest in _leaves(field.annotation, None if value is None else getattr(value, name)):
                yield field.alias or name, *rest
    elif isinstance(value, Mapping):
        within = next((get_args(one)[1] for one in kinds if get_origin(one) is dict), Any)
        for key, own in value.items():
            for rest in _leaves(within, own):
                yield str(key), *rest
    elif isinstance(value, bool | int | float) or (value is None and (Any in kinds or {float, int} & set(kinds))):
        yield ()


def _alternatives(kind: Any) -> Iterator[Any]:
    """What a value may be, of an annotation."""
    if get_origin(kind) in (None, dict, list, tuple):
        yield kind
    elif hasattr(kind, "__metadata__"):
        yield from _alternatives(get_args(kind)[0])
    else:
        for one in get_args(kind):
            yield from _alternatives(one)


def _unit(path: Path) -> str:
    """Of a number, from the keys that lead to it."""
    if path[0] in ("peak", "rms"):
        return VARIABLES[path[1]][1]
    if path[0].startswith("third_octave_"):
        return QUANTITIES[path[0].removeprefix("third_octave_")]
    if path[0] == "levels" and (path[1] in QUANTITIES or path[1] == "peak"):
        return QUANTITIES.get(path[1], "m/s")
    for key in reversed(path):
        for end, unit in UNITS.items():
            if key.endswith(end):
                return unit
    return "1"


SOURCES.add(FIRST, Runs())

"""A user's own Python functions as figures of merit."""

import hashlib
import inspect
import marshal
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Final

from ehamj.errors import InputError
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, Merit, Source
from ehamj.scenario.model import Scenario

OWN: Final = "own"
"""First word of their names."""


@dataclass(frozen=True)
class Own:
    """A figure of merit of the user's: a ``function`` of a design's scenario that returns a number in ``unit``."""

    function: Callable[[Scenario], float]
    unit: str = "1"
    text: str = ""

    def digest(self) -> str:
        """What tells the function from one that computes something else: a hash of its source."""
        return hashlib.sha256(_told(self.function)).hexdigest()[:16]


def _told(function: Any) -> bytes:
    """What a function computes: its source, with what it closes over and has by default."""
    if isinstance(function, partial):
        return _told(function.func) + repr((function.args, sorted(function.keywords.items()))).encode()
    code = getattr(function, "__code__", None)
    try:
        told = inspect.getsource(function).encode()
    except (OSError, TypeError):  # typed into a console, or no function but an object that is called
        told = repr(function).encode() if code is None else marshal.dumps(code)
    if code is None:
        return told
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    inner = b"".join(_told(one) if callable(one) else repr(one).encode() for one in cells)
    return told + inner + repr((function.__defaults__, function.__kwdefaults__)).encode()


@dataclass(frozen=True)
class OwnFunctions(Source):
    """Functions that a study was given, by name; see `owned`."""

    functions: Mapping[str, Own] = field(default_factory=dict)

    block: ClassVar[int] = 8
    """A function may take long, and what is finished is kept block by block."""

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        """One for each function."""
        return {name: Merit(name, own.unit, own.text or "of the user's") for name, own in self.functions.items()}

    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        """What each function returns of each design."""
        return [self._of(machine, design, names) for design in designs]

    def _of(self, machine: Machine, design: Design, names: Sequence[str]) -> Found:
        found = {}
        try:
            scenario = scenario_of(machine, design.values, design.known)
        except InputError as error:
            return Failed(str(error))
        for name in names:
            try:
                found[name] = float(self.functions[name].function(scenario))
            except Exception as error:  # it is not ours
                return Failed(f"{name}: {type(error).__name__}: {error}")
            if math.isinf(found[name]):
                return Failed(f"{name}: is infinite")
        return found


SOURCES.add(OWN, OwnFunctions())


def owned(functions: Mapping[str, Any]) -> dict[str, Own]:
    """Functions as a user gives them, ``{"cost": function}`` or ``{"cost": Own(function, "EUR")}``, by the names that
    a study asks for them by: ``own.cost``.

    Raises:
        InputError: if one is no function.
    """
    found = {}
    for name, given in functions.items():
        own = given if isinstance(given, Own) else Own(given)
        if not callable(own.function):
            raise InputError(f"functions: {name!r}: must be a function of a scenario, not {type(given).__name__}")
        found[f"{OWN}.{name.removeprefix(f'{OWN}.')}"] = own
    return found


def check_owned(names: Sequence[str], functions: Mapping[str, Own]) -> None:
    """Refuse names of own merits for which there is no function.

    Raises:
        InputError: which says how to give one.
    """
    for name in names:
        if name.partition(".")[0] == OWN and name not in functions:
            word: Any = name.partition(".")[2]
            raise InputError(
                f"merit {name!r}: is a function of your own, which is given in Python: "
                f"ehamj.run_study(…, functions={{{word!r}: function}}); given are {', '.join(functions) or 'none'}"
            )

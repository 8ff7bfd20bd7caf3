"""ehamj: open simulator for active hydraulic machine isolation.

import ehamj
result = ehamj.simulate("recorded")
print(result)
result.dataset["cg_velocity"]
"""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from ehamj.above import ABOVE

if TYPE_CHECKING:
    __version__: str
    from ehamj.campaign.run import run_study as run_study
    from ehamj.control import (
        Controller as Controller,
    )
    from ehamj.control import (
        ControllerBank as ControllerBank,
    )
    from ehamj.control import (
        PythonController as PythonController,
    )
    from ehamj.control import (
        load_controller as load_controller,
    )
    from ehamj.errors import DerivedAnew as DerivedAnew
    from ehamj.errors import InputError as InputError
    from ehamj.errors import SimulationFailed as SimulationFailed
    from ehamj.identification.identify import identify as identify
    from ehamj.identification.planning.asked import plan_tests as plan_tests
    from ehamj.result import Result as Result
    from ehamj.result import load_result as load_result
    from ehamj.run.many import simulate_many as simulate_many
    from ehamj.run.simulate import simulate as simulate
    from ehamj.run.stepper import Stepper as Stepper
    from ehamj.scenario.load import load_scenario as load_scenario
    from ehamj.scenario.load import parse_scenario as parse_scenario
    from ehamj.scenario.model import Scenario as Scenario
    from ehamj.studies.catalogue import study as study
    from ehamj.views.linear import linearise as linearise
    from ehamj.views.seen import sampled_plant as sampled_plant
    from ehamj.views.statics import static_loads as static_loads

_HOME: Final = {
    "Controller": "control",
    "ControllerBank": "control",
    "DerivedAnew": "errors",
    "InputError": "errors",
    "PythonController": "control",
    "Result": "result",
    "Scenario": "scenario.model",
    "SimulationFailed": "errors",
    "Stepper": "run.stepper",
    "identify": "identification.identify",
    "linearise": "views.linear",
    "load_controller": "control",
    "load_result": "result",
    "load_scenario": "scenario.load",
    "parse_scenario": "scenario.load",
    "plan_tests": "identification.planning.asked",
    "run_study": "campaign.run",
    "sampled_plant": "views.seen",
    "simulate": "run.simulate",
    "simulate_many": "run.many",
    "static_loads": "views.statics",
    "study": "studies.catalogue",
}
"""Where each name stands: its module is imported when the name is first used, so that nothing waits for the others."""

__all__ = list(_HOME)


def _above(module: str, name: str) -> Callable[..., Any]:
    """A function of a module that is imported when it is called."""
    return lambda *given: getattr(import_module(f"{__name__}.{module}"), name)(*given)


ABOVE |= {
    "save": _above("store", "save"),
    "plot": _above("report.alone", "Plots"),
    "replay": _above("replay.shown", "shown"),
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("ehamj")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME, "__version__"})

"""ehamj: open simulator for active hydraulic machine isolation.

import ehamj
result = ehamj.simulate("recorded")
print(result)
result.dataset["cg_velocity"]
"""

from ehamj.control import Controller, ControllerBank, PythonController, load_controller
from ehamj.errors import DerivedAnew, InputError, SimulationFailed
from ehamj.linear.machine import linearise
from ehamj.linear.seen import sampled_plant
from ehamj.linear.statics import static_loads
from ehamj.result import Result, load_result
from ehamj.run.simulate import simulate, simulate_many
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.store import save as _save  # noqa: F401  # so that a result can be saved
from ehamj.studies.catalogue import study

__all__ = [
    "Controller",
    "ControllerBank",
    "DerivedAnew",
    "InputError",
    "PythonController",
    "Result",
    "Scenario",
    "SimulationFailed",
    "linearise",
    "load_controller",
    "load_result",
    "load_scenario",
    "parse_scenario",
    "sampled_plant",
    "simulate",
    "simulate_many",
    "static_loads",
    "study",
]

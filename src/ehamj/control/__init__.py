"""Digital controllers: any discrete linear law, several of them, or a function, from named channels to the valves."""

from pathlib import Path
from typing import Any

from ehamj.control.bank import ControllerBank, load_controller
from ehamj.control.function import PythonController
from ehamj.control.law import Controller
from ehamj.errors import InputError

__all__ = [
    "AnyController",
    "Controller",
    "ControllerBank",
    "LinearController",
    "PythonController",
    "as_controller",
    "load_controller",
]

LinearController = Controller | ControllerBank
AnyController = Controller | ControllerBank | PythonController


def as_controller(given: Any) -> AnyController:
    """What can run: a controller as it is, that of a file, a python-control system with ``dt`` by
    `Controller.from_statespace`.

    Raises:
        InputError: if it is none of these.
    """
    if isinstance(given, str | Path):
        return load_controller(given)
    if isinstance(given, AnyController):
        return given
    if hasattr(given, "dt"):
        return Controller.from_statespace(given)
    if callable(given):
        raise InputError("controller: a function needs its channels and period; wrap it in ehamj.PythonController")
    kinds = "ehamj.Controller, ControllerBank, PythonController, the file of a law, or a python-control system with dt"
    raise InputError(f"controller: is a {type(given).__name__}; it must be an {kinds}")

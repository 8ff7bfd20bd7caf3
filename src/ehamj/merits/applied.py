"""Designs as machines: a scenario with a design's values, and a stack of designs for closed forms."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ehamj.control.settings import DigitalSettings
from ehamj.designs.designs import Designs
from ehamj.designs.parameters import changes_of
from ehamj.merits.merit import Machine
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import unlike


def scenario_of(machine: Machine, values: Mapping[str, Any], known: Mapping[str, Any] | None = None) -> Scenario:
    """The scenario of one design; its law is held, or derived from it, as the machine says.

    Args:
        machine: what the design differs from.
        values: by key of a scenario, and ``footprint.x``, ``footprint.y`` and ``mount.NAME.actuator.QUANTITY``
            (`ehamj.designs.parameters.changes_of`).
        known: the values that a law derived for the design knows of; all without.

    Raises:
        InputError: if a key is none, or a value is impossible.
    """
    base = machine.scenario
    if machine.law == "held" or not isinstance(base.control, DigitalSettings):
        return base.varied(changes_of(base, values))
    base = base.model_copy(update={"control": base.control.model_copy(update={"designed_for": None})})
    found = changed(base, changes_of(base, values))
    if known is None or not isinstance(found.control, DigitalSettings):
        return found
    believed = changed(base, changes_of(base, known)).installation
    if not unlike(believed, found.installation):
        return found
    return found.model_copy(update={"control": found.control.model_copy(update={"designed_for": believed})})


def designs_of(machine: Machine, values: Sequence[Mapping[str, Any]]) -> Designs:
    """A stack of designs along the dimension ``design``.

    Args:
        machine: what they differ from.
        values: of each design, all with the same keys, numbers only.

    Raises:
        InputError: as `Designs.of`, naming a key and the first value that is impossible.
    """
    keys = list(values[0]) if values else []
    columns = {key: xr.DataArray(np.array([one[key] for one in values], float), dims="design") for key in keys}
    return Designs.of(machine.scenario, columns)

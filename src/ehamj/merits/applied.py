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


def scenario_of(machine: Machine, values: Mapping[str, Any]) -> Scenario:
    """The scenario of one design; its law is held, or derived from it, as the machine says.

    Args:
        machine: what the design differs from.
        values: by key of a scenario, and ``footprint.x``, ``footprint.y`` and ``mount.NAME.actuator.QUANTITY``
            (`ehamj.designs.parameters.changes_of`).

    Raises:
        InputError: if a key is none, or a value is impossible.
    """
    base = machine.scenario
    if machine.law == "derived" and isinstance(base.control, DigitalSettings):
        base = base.model_copy(update={"control": base.control.model_copy(update={"designed_for": None})})
        return changed(base, changes_of(base, values))
    return base.varied(changes_of(base, values))


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

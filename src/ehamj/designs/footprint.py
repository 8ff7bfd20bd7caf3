"""Rocking over what a designer chooses first: height of the centre of gravity and distance of the mounts."""

from typing import Final

import xarray as xr

from ehamj.designs.designs import Designs
from ehamj.designs.many import modes_of
from ehamj.designs.parameters import FOOTPRINT, footprint
from ehamj.scenario.model import Scenario

LOWER: Final = ("lower about x", "lower about y")
"""The two modes in which a machine sways and rocks slowest."""

STILL: Final = 1e-3
"""Frequency below which a pair of poles is rounding about zero, no oscillation [Hz]."""


def rocking_modes(scenario: Scenario, height: xr.DataArray, width: xr.DataArray) -> xr.Dataset:
    """Modes of the machine with its valves held, over other heights and footprints; mass and inertia are kept.

    Args:
        scenario: the machine.
        height: of the CG above the mount plane [m].
        width: factor on the mounts' places [-].

    Returns:
        ``frequency`` [Hz] and ``damping_ratio`` per mode, ``growth_rate`` [1/s] and ``tipping_margin`` [-] of
        `ehamj.designs.many.modes_of`, over the dimensions of both arguments.

    Raises:
        InputError: if the machine has no linear model in closed form.
    """
    spread = {key: footprint(scenario.plant, key) * width for key in FOOTPRINT}
    vary = {"machine.cg.2": height, **spread}
    found = modes_of(Designs.of(scenario, vary))[["frequency", "damping_ratio", "growth_rate", "tipping_margin"]]
    found["frequency"] = found["frequency"].where(found["frequency"] > STILL)
    return found.reset_coords(drop=True).assign_attrs(title="modes of the designs")


def slowest_rocking(modes: xr.Dataset) -> xr.DataArray:
    """Frequency of the slower of the two lower modes [Hz]; NaN where one does not oscillate."""
    return modes["frequency"].sel(mode=list(LOWER)).min("mode", skipna=False)

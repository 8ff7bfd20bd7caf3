"""Peak and RMS of every variable of a run."""

from typing import Any

import xarray as xr

from ehamj.findings import finite


def peak_and_rms(dataset: xr.Dataset) -> tuple[dict[str, Any], dict[str, Any]]:
    """Peak and RMS of every variable and channel about its first value, which is the equilibrium; commands about 0.

    States of the controller are left out: nobody asks for them first.
    """
    peak: dict[str, Any] = {}
    rms: dict[str, Any] = {}
    for name, variable in dataset.data_vars.items():
        if not variable.size or name == "controller_state":
            continue
        about = variable if name == "valve_command" else variable - variable[0]
        peak[str(name)] = _nested(abs(about).max("time"))
        rms[str(name)] = _nested((about**2).mean("time") ** 0.5)
    return peak, rms


def _nested(values: xr.DataArray) -> Any:
    """Labelled numbers as nested dictionaries; a number that is not finite becomes None."""
    if values.ndim == 0:
        return finite(float(values))
    dimension = values.dims[0]
    return {str(label): _nested(values.sel({dimension: label})) for label in values[dimension].values}

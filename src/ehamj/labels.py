"""Labelled datasets: every variable and coordinate with its unit and what it is."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

Column = tuple[Any, str, str]
"""Values, unit ("" for names and flags) and what they are."""


def labelled(
    dims: str | tuple[str, ...], values: Any, units: str, long_name: str = ""
) -> tuple[Any, Any, dict[str, str]]:
    """A variable for `xarray.Dataset`; ``units`` "" for what has none (names, flags)."""
    attributes = {"long_name": long_name, "units": units}
    return dims, values, {name: text for name, text in attributes.items() if text}


def table(
    title: str, over: Mapping[str, Column], **variables: Column | tuple[tuple[str, ...], Any, str, str]
) -> xr.Dataset:
    """Variables over all the dimensions ``over``, in this order, or over those of them that stand before the values."""
    return xr.Dataset(
        {
            name: labelled(*column) if len(column) == 4 else labelled(tuple(over), *column)
            for name, column in variables.items()
        },
        {name: labelled((name,), *column) for name, column in over.items()},
        {"title": title},
    )

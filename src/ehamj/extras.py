"""Packages that only some of ehamj needs: which extra of it brings each, and what is said where one is missing."""

import importlib.util
from types import MappingProxyType
from typing import Final, NamedTuple

from ehamj.errors import InputError


class Package(NamedTuple):
    """What people call it, and the extra of ehamj that brings it."""

    name: str
    extra: str


EXTRAS: Final = MappingProxyType(
    {
        "SALib": Package("SALib", "studies"),
        "pymoo": Package("pymoo", "studies"),
        "distributed": Package("Dask", "dask"),
        "pythonfmu": Package("PythonFMU", "export"),
        "rerun_notebook": Package("Rerun's notebook viewer", "notebook"),
        "exudyn": Package("Exudyn", "peer"),
    }
)
"""Packages by the name that is imported."""


def check_extra(package: str, key: str) -> None:
    """Refuse what needs a package that is not installed.

    Args:
        package: one of `EXTRAS`.
        key: what needs it, with its value, as the message begins.

    Raises:
        InputError: which says how it is installed.
    """
    if importlib.util.find_spec(package) is None:
        name, extra = EXTRAS[package]
        raise InputError(f"{key}: needs {name}, which is not installed here: pip install 'ehamj[{extra}]'")

"""Laws in MATLAB files, as the tables that `ehamj.control.foreign` understands; nothing in a file is run."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.control.foreign import BEYOND, SPELLINGS
from ehamj.errors import InputError
from ehamj.plain.text import LARGEST_TEXT
from ehamj.records.matlab_files import opened
from ehamj.records.matlab_values import Numbers, Opaque, Value

KEY: Final = "control.file"
MATRICES: Final = {*(name for key in "ABCD" for name in SPELLINGS[key]), "anti_windup", "E", "e"}
AS_STRUCT: Final = (
    "s = struct('A', sys.A, 'B', sys.B, 'C', sys.C, 'D', sys.D, 'Ts', sys.Ts, 'InputName', {sys.InputName}, "
    "'OutputName', {sys.OutputName}); save('law.mat', 's', '-v7')"
)
"""What makes a struct of a system, in MATLAB; Octave has sys.tsam, sys.inname and sys.outname instead."""


def matlab_table(path: Path) -> dict[str, Any]:
    """The law in a MATLAB file as plain data: the variable ``law``, the one struct with matrices, or the matrices
    themselves.

    Raises:
        InputError: if the file cannot be read, or has no law, or more than one.
    """
    try:
        with opened(path, KEY, LARGEST_TEXT) as tree:
            return _table(path, tree)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(str(error)) from error


def _table(path: Path, tree: Mapping[str, Value]) -> dict[str, Any]:
    where = f"{KEY} = {str(path)!r}"
    named = {"law": tree["law"]} if "law" in tree else tree
    objects = [f"{name} ({value.kind})" for name, value in named.items() if isinstance(value, Opaque)]
    systems = [name for name, value in named.items() if _is_system(value) and not name.startswith("plant")]
    if len(systems) > 1:
        raise InputError(f"{where}: {', '.join(systems)} could each be the law; call the one that is 'law'")
    if systems:
        found = named[systems[0]]
        return {"law": [_plain(where, one) for one in found] if isinstance(found, list) else _plain(where, found)}
    if {"A", "B", "C", "D"} <= tree.keys():
        return {"law": _plain(where, tree)}
    if objects:
        raise InputError(
            f"{where}: only MATLAB can read {', '.join(objects)}; of a system sys make a struct: {AS_STRUCT}"
        )
    held = ", ".join(tree) or "nothing"
    raise InputError(f"{where}: holds {held}, and no law: a struct of A, B, C, D, dt and names; {AS_STRUCT}")


def _is_system(value: Value) -> bool:
    """Whether a variable is a struct with matrices, or an array of them."""
    structs = value if isinstance(value, list) else [value]
    return bool(structs) and all(isinstance(one, dict) and ("A" in one or "a" in one) for one in structs)


def _plain(where: str, struct: Any) -> dict[str, Any]:
    """A struct as plain data: matrices as lists of rows, single numbers as such, what is empty as none."""
    return {key: _value(f"{where}: {key}", key, value) for key, value in struct.items()}


def _value(where: str, key: str, value: Value) -> Any:
    if isinstance(value, Opaque):
        return None
    if value == [] or (isinstance(value, Numbers) and 0 in value.shape):
        return [] if key in MATRICES - {"anti_windup", "E", "e"} else None
    if isinstance(value, list):
        return [one.rstrip() if isinstance(one, str) else _value(where, key, one) for one in value]
    if isinstance(value, str) or not isinstance(value, Numbers):
        return value.strip() if isinstance(value, str) and key != BEYOND else value
    if value.complex:
        raise InputError(f"{where}: has complex entries; every entry must be a real number")
    numbers = np.asarray(value.read(), float)
    if key in MATRICES:
        return np.atleast_2d(numbers).tolist()
    if numbers.size > 1:
        return numbers.tolist()
    number = float(numbers.ravel()[0])
    if value.logical or (key == "from_rest" and number in (0.0, 1.0)):
        return bool(number)
    return int(number) if key == "bits" and number.is_integer() else number

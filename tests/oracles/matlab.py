"""Writers of MATLAB files for tests: SciPy's up to version 7; version 7.3 is HDF5 as MATLAB lays it out."""

import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import savemat


def save_hdf5(path: Path, variables: dict[str, Any]) -> None:
    """A file of version 7.3, as MATLAB writes it."""
    with h5py.File(path, "w", userblock_size=512) as file:
        kept = file.create_group("#refs#")

        def put(group: h5py.Group, name: str, value: Any) -> None:
            if isinstance(value, dict):
                child = group.create_group(name)
                child.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, part in value.items():
                    put(child, key, part)
                return
            if isinstance(value, list) and value and isinstance(value[0], dict):  # a struct array
                child = group.create_group(name)
                child.attrs["MATLAB_class"] = np.bytes_("struct")
                for key in value[0]:
                    child[key] = references([part[key] for part in value])
                return
            if isinstance(value, list):
                group[name] = references(value)
                group[name].attrs["MATLAB_class"] = np.bytes_("cell")
            elif isinstance(value, str):
                group[name] = np.array([[ord(c)] for c in value], np.uint16)
                group[name].attrs["MATLAB_class"] = np.bytes_("char")
            else:
                group.create_dataset(name, data=np.atleast_2d(value).T, chunks=True, compression="gzip")
                group[name].attrs["MATLAB_class"] = np.bytes_("double")

        def references(values: list[Any]) -> np.ndarray:
            found = np.empty((len(values), 1), h5py.ref_dtype)
            for n, value in enumerate(values):
                name = f"r{len(kept)}"
                put(kept, name, value)
                found[n, 0] = kept[name].ref
            return found

        for name, value in variables.items():
            put(file, name, value)
    content = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + struct.pack("<H", 0x0200) + b"IM" + content[128:])


def save_plain(path: Path, variables: dict[str, Any], **options: Any) -> None:
    """A file up to version 7: lists of structs are struct arrays, other lists are cells."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(part) for key, part in value.items()}
        if isinstance(value, list) and value and isinstance(value[0], dict):
            found = np.empty((1, len(value)), [(key, "O") for key in value[0]])
            for n, part in enumerate(value):
                found[0, n] = tuple(plain(one) for one in part.values())
            return found
        if isinstance(value, list):
            cells = np.empty((1, len(value)), object)
            cells[0] = [plain(one) for one in value]
            return cells
        return value

    savemat(path, plain(variables), **options)

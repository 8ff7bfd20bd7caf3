"""MATLAB files of version 7.3, which are HDF5, through h5py.

Only what MATLAB writes is followed: hard links and references, and numbers stored plain or deflated; what would load
plug-ins is refused here, and what would open other files by `ehamj.plain.hdf5`.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ehamj.records.files import reading
from ehamj.records.matlab_values import DEEPEST, MOST_PARTS, Numbers, Opaque, Value, check_size, dense

FILTERS = {1: "deflate", 2: "shuffle", 3: "Fletcher's checksum"}
"""HDF5 filters that MATLAB uses; others would be loaded from plug-ins."""


class Hdf5:
    """Reads a file: groups are structs, references cells and struct arrays."""

    def __init__(self, path: Path, file: Any) -> None:
        self.path = path
        self.file = file
        self.taken = 0

    def variables(self) -> dict[str, Value]:
        """The file's variables, by name."""
        return {name: self.child(self.file, name, name, 0) for name in self.file if name[:1] != "#"}

    def child(self, parent: Any, key: str, name: str, depth: int) -> Value:
        """A member of a group as a value."""
        return self.value(self.linked(parent, key, name), name, depth)

    def linked(self, parent: Any, key: str, name: str) -> Any:
        """A member of a group; raises ValueError where it is not in the file itself."""
        import h5py

        link = parent.get(key, getlink=True)
        if not isinstance(link, h5py.HardLink):
            where = getattr(link, "filename", None) or getattr(link, "path", "elsewhere")
            raise ValueError(f"{name} is a link to {where!r}; only what is in the file itself is read")
        return parent[key]

    def value(self, item: Any, name: str, depth: int) -> Value:
        """A group or dataset as a value."""
        import h5py

        self.taken += 1
        if depth > DEEPEST or self.taken > MOST_PARTS:
            raise ValueError(f"{name} is more than {DEEPEST} structs deep, or holds itself; save a plain struct")
        kind = item.attrs.get("MATLAB_class", b"")
        kind = kind.decode() if isinstance(kind, bytes) else str(kind)
        if "MATLAB_object_decode" in item.attrs:
            return Opaque(kind or "object")
        if isinstance(item, h5py.Group):
            return self.sparse(item, name) if "MATLAB_sparse" in item.attrs else self.struct(item, name, depth)
        if not isinstance(item, h5py.Dataset):
            return Opaque(type(item).__name__)
        if _refers(item):
            _check_stored(item, name)
            return [self.value(self.file[one], name, depth + 1) for one in np.ravel(item[()].T) if one]
        if item.attrs.get("MATLAB_empty"):
            return "" if kind == "char" else []
        if kind == "char":
            _check_stored(item, name)
            lines = ["".join(chr(int(code)) for code in line) for line in np.atleast_2d(item[()].T)]
            return lines[0] if len(lines) == 1 else list(lines)
        if item.dtype.names == ("real", "imag"):
            return Numbers(item.shape[::-1], lambda: self.numbers(item, name), True)
        if item.dtype.kind not in "iufb":
            return Opaque(kind or str(item.dtype))
        return Numbers(item.shape[::-1], lambda: self.numbers(item, name), logical=kind == "logical")

    def numbers(self, item: Any, name: str) -> np.ndarray:
        """The numbers of a dataset, as MATLAB has them."""
        with reading(self.path, f" as a MATLAB file: {name}"):
            _check_stored(item, name)
            return np.asarray(item[()]).T

    def struct(self, group: Any, name: str, depth: int) -> Value:
        """A struct, or a struct array: there each field is a list of references."""
        fields = {key: self.child(group, key, f"{name}.{key}", depth + 1) for key in group}
        arrays = [key for key in fields if "MATLAB_class" not in group[key].attrs]  # cells have one
        lists = [one for one in map(fields.get, arrays) if isinstance(one, list)]
        if not lists or len(lists) < len(fields) or len({len(one) for one in lists}) != 1:
            return fields
        return [dict(zip(fields, one, strict=True)) for one in zip(*lists, strict=True)]

    def sparse(self, group: Any, name: str) -> Value:
        """A sparse matrix: data, rows ``ir`` and columns' beginnings ``jc``."""
        from scipy.sparse import csc_matrix

        if not {"data", "ir", "jc"} <= set(group):
            return []
        parts = []
        for key in ("data", "ir", "jc"):
            item = self.linked(group, key, name)
            _check_stored(item, f"{name}.{key}")
            parts.append(np.asarray(item[()]))
        shape = (int(group.attrs["MATLAB_sparse"]), parts[2].size - 1)
        check_size(name, shape)
        matrix = csc_matrix((parts[0].ravel(), parts[1].ravel(), parts[2].ravel()), shape=shape)
        return Numbers(shape, lambda: dense(matrix, name))


def _refers(item: Any) -> bool:
    import h5py

    return h5py.check_ref_dtype(item.dtype) is h5py.Reference


def _check_stored(item: Any, name: str) -> None:
    """Raise ValueError where a dataset is too large, or needs more than MATLAB's own filters."""
    check_size(name, item.shape or ())
    plan = item.id.get_create_plist()
    for number in range(plan.get_nfilters()):
        code, _, _, words = plan.get_filter(number)
        if code not in FILTERS:
            told = f"{code} {words.decode(errors='replace')}".strip()
            raise ValueError(f"{name} is stored with the filter {told}; known are {', '.join(FILTERS.values())}")
    if item.chunks is not None:
        check_size(f"a chunk of {name}", item.chunks)

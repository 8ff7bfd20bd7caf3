"""HDF5 files that stand alone: no data in other files, and no more than fits into memory."""

from pathlib import Path

LARGEST = 2**32
"""Most that the arrays of one file may unfold to [byte]."""
MOST_PARTS = 100_000
"""Most groups and arrays that one file may hold."""


def check_hdf5(path: Path, largest: int = LARGEST) -> None:
    """Raise ValueError where a file draws in others, is damaged, or unfolds to more than so many bytes.

    HDF5 knows three ways into another file: external links, external storage of an array, and virtual arrays.
    """
    try:
        _check(path, largest)
    except (OSError, KeyError, RuntimeError, TypeError) as error:  # h5py raises one or the other, as the damage lies
        raise ValueError(str(error).strip("'\"")) from error


def _check(path: Path, largest: int) -> None:
    import h5py

    with h5py.File(path, "r") as file:
        groups, seen, size = [file["/"]], {h5py.h5o.get_info(file.id).addr}, 0
        while groups:
            group = groups.pop()
            for name in list(group):
                if isinstance(group.get(name, getlink=True), h5py.SoftLink):
                    continue  # leads to a part of this file, or nowhere
                where = f"{group.name.rstrip('/')}/{name}"
                if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                    raise ValueError(f"{where} is a link into another file; copy what it leads to into this one")
                part = group[name]
                at = h5py.h5o.get_info(part.id).addr
                if at in seen:
                    continue
                seen.add(at)
                if len(seen) > MOST_PARTS:
                    raise ValueError(f"it holds more than {MOST_PARTS} parts")
                if isinstance(part, h5py.Group):
                    groups.append(part)
                elif isinstance(part, h5py.Dataset):
                    if part.is_virtual or part.external:
                        raise ValueError(f"{where} keeps its values in another file; copy them into this one")
                    size += part.nbytes
                    if size > largest:
                        raise ValueError(
                            f"its arrays unfold to more than {largest / 2**30:.3g} GiB (at {where}); cut it into parts"
                        )

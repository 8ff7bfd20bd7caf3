"""Finished designs as pandas and xarray have them, and in files that everything opens."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ehamj.campaign.rows import Column
from ehamj.campaign.store import FIXED, Store, reading
from ehamj.result import written_whole

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

PARQUET_FILE: Final = "designs.parquet"
CSV_FILE: Final = "designs.csv"
PIECE: Final = 4096
"""Designs that are in memory at a time where a store is written to other files."""
ABOUT: Final = {
    "number": "number of the design",
    "stage": "stage of the study",
    "parent": "number of the design that it is a variation of",
    "status": "done, or failed",
    "reason": "why it failed",
    "seconds": "time that it took",
}


def frame(folder: str | Path, stage: str | None = None) -> "pd.DataFrame":
    """All finished designs by number: stage, parent, status, reason, seconds, then values and merits by their dotted
    names; ``attrs["units"]`` holds their units. Lists are in it as JSON.

    Args:
        folder: of a study, which may still run.
        stage: only its designs.

    Raises:
        InputError: if the folder holds no designs.
    """
    import pandas as pd

    with reading(Path(folder)) as store:
        numeric = _numeric(store)
        pieces = list(_pieces(store, numeric, stage))
        found = pd.concat(pieces) if len(pieces) > 1 else pieces[0]
        found.attrs["units"] = {"seconds": "s", **{column.name: column.unit for column in store.columns}}
    return found


def dataset(folder: str | Path, stage: str | None = None) -> "xr.Dataset":
    """As `frame`, along the dimension ``design``, whose coordinate is the number; each variable has ``long_name`` and,
    where it is a number, ``units``. A design without parent has −1.

    Raises:
        InputError: if the folder holds no designs.
    """
    found = frame(folder, stage)
    units = found.attrs.pop("units")
    found = found.rename_axis("design")
    found["parent"] = found["parent"].fillna(-1).astype("int64")
    found["reason"] = found["reason"].fillna("")
    table = found.to_xarray()
    with reading(Path(folder)) as store:
        texts = ABOUT | {column.name: column.text or column.name for column in store.columns}
    for name, variable in table.data_vars.items():
        variable.attrs["long_name"] = texts[str(name)]
        if variable.dtype.kind == "f":
            variable.attrs["units"] = units[str(name)]
    table["design"].attrs["long_name"] = ABOUT["number"]
    return table


def export(folder: str | Path) -> tuple[Path, Path]:
    """Write all finished designs as Parquet and as CSV into the study's folder, heads with units; a piece at a time.

    Raises:
        InputError: if the folder holds no designs.
        OSError: if a file cannot be written; the one that was there stays.
    """
    import pyarrow
    import pyarrow.parquet

    folder = Path(folder)
    paths = folder / PARQUET_FILE, folder / CSV_FILE
    with reading(folder) as store, written_whole(paths[0]) as parquet, written_whole(paths[1]) as csv:
        numeric = _numeric(store)
        schema, writer = None, None
        heads = {"seconds": "seconds [s]", **{column.name: column.head for column in store.columns}}
        try:
            for at, piece in enumerate(_pieces(store, numeric)):
                table = piece.rename(columns=heads)
                table.to_csv(csv, mode="a" if at else "w", header=not at, encoding="utf-8")
                schema = schema or _schema(pyarrow, store, numeric, heads)
                writer = writer or pyarrow.parquet.ParquetWriter(parquet, schema)
                writer.write_table(pyarrow.Table.from_pandas(table.reset_index(), schema, preserve_index=False))
        finally:
            if writer is not None:
                writer.close()
    return paths


def _pieces(store: Store, numeric: Sequence[bool], stage: str | None = None) -> "Iterator[pd.DataFrame]":
    """Finished designs, some at a time, at least one piece."""
    import pandas as pd

    cells = ", ".join(f'"{name}"' for name in (*FIXED, *(one.replace('"', '""') for one in store.labels.values())))
    names = [*FIXED, *store.labels]
    where, given = ("WHERE stage = ?", (stage,)) if stage else ("", ())
    cursor = store.execute(f"SELECT {cells} FROM designs {where} ORDER BY number", given)
    first = True
    while (rows := cursor.fetchmany(PIECE)) or first:
        first = False
        piece = pd.DataFrame(rows, columns=names).set_index("number")
        kinds: dict[str, Any] = {
            "stage": "str",
            "status": "str",
            "reason": "str",
            "parent": "Int64",
            "seconds": "float64",
        }
        kinds |= {
            one.name: "float64" if is_number else "str" for one, is_number in zip(store.columns, numeric, strict=True)
        }
        yield piece.astype(kinds)


def _numeric(store: Store) -> list[bool]:
    """Which columns hold numbers only."""
    return [column.role == "merit" or _is_numeric(store, column) for column in store.columns]


def _is_numeric(store: Store, column: Column) -> bool:
    label = store.labels[column.name].replace('"', '""')
    return not store.execute(f"SELECT 1 FROM designs WHERE typeof(\"{label}\") = 'text' LIMIT 1").fetchone()


def _schema(pyarrow: Any, store: Store, numeric: Sequence[bool], heads: Any) -> Any:
    kinds = {"number": pyarrow.int64(), "parent": pyarrow.int64(), "seconds": pyarrow.float64()}
    fields = [pyarrow.field(heads.get(name, name), kinds.get(name, pyarrow.string())) for name in FIXED]
    own = zip(store.columns, numeric, strict=True)
    return pyarrow.schema(
        [*fields, *(pyarrow.field(one.head, pyarrow.float64() if many else pyarrow.string()) for one, many in own)]
    )

"""A store keeps blocks whole, values as they are, and says what is wrong with a file."""

import sqlite3
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.campaign.held import myself
from ehamj.campaign.rows import Column, Row
from ehamj.campaign.store import MOST, STORE_FILE, Store, cell_of, reading, value_of, writing
from ehamj.errors import InputError
from ehamj.merits.merit import Failed

COLUMNS = (Column("machine.mass", "kg", "value"), Column("fake.sum", "kg", "merit"))


def row(number: int, mass: Any = 1.0, **merits: float) -> Row:
    return Row(number, "search", None, {"machine.mass": mass}, {f"fake.{name}": one for name, one in merits.items()})


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    rows = [
        row(0, 0.1 + 0.2, sum=1 / 3),
        Row(1, "tolerance", 0, {"machine.mass": 4000}, {}, Failed("it tips"), 0.25),
        row(2, [1.0, "a"], sum=-0.0),
    ]
    with writing(tmp_path, COLUMNS, {}) as (store, there):
        assert not there
        store.append(rows)
    with reading(tmp_path) as store:
        assert list(store.rows()) == rows
        assert list(store.rows(1, 2)) == rows[1:2]
        assert (store.count(), store.count(failed=True), store.count(2)) == (3, 1, 1)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | st.text(), st.lists
    )
)
def test_any_value_of_a_scenario_is_read_as_it_was(value: Any) -> None:
    assert value_of(cell_of(value)) == value
    assert type(value_of(cell_of(value))) is type(value)


def test_a_block_is_there_whole_or_not_at_all(tmp_path: Path) -> None:
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        store.append([row(0)])
        with pytest.raises(ValueError, match="designs 1 to 0: UNIQUE"):
            store.append([row(1), row(0)])
        with pytest.raises(ValueError, match="no column"):
            store.append([row(1), row(2, other=1.0)])
        assert store.count() == 1


def test_pandas_opens_the_file_itself(tmp_path: Path) -> None:
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        store.append([row(number, 10.0 * number, sum=number) for number in range(3)])
    connection = sqlite3.connect(tmp_path / STORE_FILE)
    table = pd.read_sql("select * from designs", connection, index_col="number")
    connection.close()
    assert table["machine.mass"].tolist() == [0.0, 10.0, 20.0]
    assert table["fake.sum"].dtype == float


def test_it_can_be_read_while_a_study_is_at_work(tmp_path: Path) -> None:
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        store.append([row(0)])
        with reading(tmp_path) as other:
            store.append([row(1)])
            assert other.count() == 2


def test_names_may_differ_in_capitals_only(tmp_path: Path) -> None:
    columns = [Column(f"actuators.{name}.leakage", "1", "value") for name in ("A", "a")]
    with writing(tmp_path, columns, {}) as (store, _):
        store.append([Row(0, "search", None, {columns[0].name: 1.0, columns[1].name: 2.0}, {})])
        assert next(store.rows()).values == {"actuators.A.leakage": 1.0, "actuators.a.leakage": 2.0}


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ([COLUMNS[0], Column("machine.mass", "kg", "merit")], "'machine.mass': is both"),
        ([Column(str(number), "1", "value") for number in range(MOST + 1)], f"a study may have {MOST}"),
    ],
)
def test_columns_that_no_table_can_have_are_refused(tmp_path: Path, columns: list[Column], said: str) -> None:
    with pytest.raises(InputError, match=said), writing(tmp_path, columns, {}):
        pass
    assert not list(tmp_path.iterdir())


def test_the_most_columns_fit(tmp_path: Path) -> None:
    columns = [Column(str(number), "1", "value") for number in range(MOST)]
    with writing(tmp_path, columns, {}) as (store, _):
        store.append([Row(0, "search", None, {one.name: 1.0 for one in columns}, {})])


def test_a_second_writer_is_told_who_is_there(tmp_path: Path) -> None:
    second = writing(tmp_path, COLUMNS, {})
    with writing(tmp_path, COLUMNS, {}), pytest.raises(InputError, match=f"{myself()} is at work on it"):
        second.__enter__()
    with writing(tmp_path, COLUMNS, {}) as (_, there):
        assert there


def other_tables(path: Path) -> None:
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE designs (number)")
    connection.close()


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda path: path.write_bytes(b"no database at all" * 100), "is damaged, or no store"),
        (other_tables, "is no store of designs that this version"),
        (lambda path: path.touch(), "is empty; no study has begun"),
        (lambda path: None, "holds no designs.sqlite"),
    ],
)
def test_what_is_no_store_is_refused(tmp_path: Path, make: Any, said: str) -> None:
    make(tmp_path / STORE_FILE)
    with pytest.raises(InputError, match=said), reading(tmp_path):
        pass


def fill(store: Store) -> OSError:
    """Append until nothing more fits; what is said then."""
    for first in range(0, 10_000, 100):
        try:
            store.append([row(number, "x" * 100) for number in range(first, first + 100)])
        except OSError as error:
            return error
    raise AssertionError("everything fits")


def test_a_full_disk_takes_no_design_that_is_stored(tmp_path: Path) -> None:
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        store.execute("PRAGMA max_page_count = 40")
        error = fill(store)
        kept = store.count()
    assert (error.strerror or "").startswith("no space is left")
    assert error.filename == str(tmp_path / STORE_FILE)
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        assert store.count() == kept
        assert kept % 100 == 0 < kept
        store.append([row(kept)])
        assert store.execute("PRAGMA integrity_check").fetchone() == ("ok",)


def test_a_file_that_must_not_grow_keeps_what_it_has(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with writing(tmp_path, COLUMNS, {}) as (store, _):
        try:
            resource.setrlimit(resource.RLIMIT_FSIZE, (10**5, before[1]))
            error = fill(store)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        kept = store.count()
        store.append([row(kept)])
        assert "finished designs are kept" in str(error)
        assert kept % 100 == 0 < kept
        assert store.execute("PRAGMA integrity_check").fetchone() == ("ok",)

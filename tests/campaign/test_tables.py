"""Finished designs as tables, in memory and in files."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from oracles.fake_studies import Drawn, closed, done, search

from ehamj.campaign import tables
from ehamj.campaign.rows import Column, Row
from ehamj.campaign.store import writing
from ehamj.campaign.tables import dataset, export, frame


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    done(folder, search(Drawn(number=24)))
    return folder


def test_a_frame_has_every_design_with_its_units(folder: Path) -> None:
    table = frame(folder)
    assert table.index.tolist() == list(range(24))
    assert table.attrs["units"]["fake.product"] == "kg m"
    assert table.loc[7, "fake.sum"] == closed(7.0, table.loc[7, "machine.cg.2"])["sum"]
    assert table.index[table["status"] == "failed"].tolist() == [5, 13, 17]
    assert np.isnan(table.loc[19, "fake.root"])
    assert frame(folder, "confirm").empty


def test_a_dataset_has_units_and_names_and_is_written_as_netcdf(folder: Path) -> None:
    table = dataset(folder)
    assert table["fake.product"].attrs == {"long_name": "in closed form", "units": "kg m"}
    assert table["fake.sum"].sel(design=3) == frame(folder).loc[3, "fake.sum"]
    table.to_netcdf(folder / "designs.nc", engine="h5netcdf")


def test_files_have_units_in_their_heads(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "PIECE", 10)
    parquet, csv = export(folder)
    own = frame(folder)
    for table in (pd.read_parquet(parquet), pd.read_csv(csv)):
        assert table["number"].tolist() == own.index.tolist()
        np.testing.assert_array_equal(table["fake.product [kg m]"], own["fake.product"])
        assert "machine.cg.2 [m]" in table
        assert table["reason"][5] == own["reason"][5]
    assert len(list(folder.glob("designs.*"))) in (3, 4)


def test_words_and_lists_are_columns_of_words(tmp_path: Path) -> None:
    with writing(tmp_path, [Column("ground.kind", "1", "value")], {}) as (store, _):
        store.append(
            [Row(at, "search", None, {"ground.kind": one}, {}) for at, one in enumerate(["rest", [1, 2], 3.0])]
        )
    assert frame(tmp_path)["ground.kind"].tolist() == ["rest", "[1, 2]", "3.0"]
    assert pd.read_parquet(export(tmp_path)[0])["ground.kind [1]"].tolist() == ["rest", "[1, 2]", "3.0"]

"""What is written stands beside its place until it is whole, and what is replaced until it has been."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ehamj.errors import PutElsewhere
from ehamj.folders import Place, new_folder
from ehamj.unfinished import HELD, _host, beside, check_room, clear_leftovers, remove_all

ABANDON = """
import os, sys
from pathlib import Path
from ehamj.folders import Place, new_folder
os.chdir(sys.argv[1])
with new_folder(Path(sys.argv[2]) if len(sys.argv) > 2 else None, True) as place:
    (place.target / "new").write_text("half")
    os._exit(9)
"""


def abandoned(folder: Path, *wanted: str) -> None:
    """A process that ends while it writes, as one that is killed."""
    assert subprocess.run([sys.executable, "-c", ABANDON, str(folder), *wanted], check=False).returncode == 9


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_what_a_dead_process_left_is_cleared_by_the_next_and_its_number_is_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    abandoned(tmp_path)
    assert len(names(tmp_path / "runs")) == 2
    monkeypatch.chdir(tmp_path)
    with new_folder(None, False) as place:
        (place.target / "whole").touch()
    assert place.folder == Path("runs/0001")
    assert names(tmp_path / "runs") == ["0001"]


def test_what_is_replaced_is_there_until_the_new_one_is(tmp_path: Path) -> None:
    result = tmp_path / "result"
    result.mkdir()
    (result / "old").touch()
    abandoned(tmp_path, "result")
    assert names(result) == ["old"]
    with pytest.raises(FileNotFoundError), new_folder(result, True) as place:
        (place.target / "nowhere" / "new").touch()
    assert names(result) == ["old"]
    with new_folder(result, True) as place:
        (place.target / "new").touch()
    assert names(result) == ["new"]
    assert names(tmp_path) == ["result"]


def raced(wanted: Path, overwrite: bool) -> tuple[Place, Place]:
    """Places of two that write one folder, the slower first."""
    with new_folder(wanted, False) as slower:
        (slower.target / "slower").touch()
        with new_folder(wanted, overwrite) as quicker:
            (quicker.target / "quicker").touch()
    return slower, quicker


@pytest.mark.parametrize("overwrite", [False, True])
def test_of_two_that_write_one_folder_the_slower_is_put_beside_it(tmp_path: Path, overwrite: bool) -> None:
    wanted = tmp_path / "result"
    (tmp_path / "result-2").mkdir()
    (tmp_path / "result-2" / "other").touch()
    with pytest.warns(PutElsewhere, match=r"result' was taken by another run meanwhile: this result is in .*result-3'"):
        slower, quicker = raced(wanted, overwrite)
    assert (quicker.folder, slower.folder) == (wanted, tmp_path / "result-3")
    assert names(wanted) == ["quicker"]
    assert names(slower.folder) == ["slower"]
    assert names(tmp_path) == ["result", "result-2", "result-3"]


def test_a_number_that_another_process_took_is_followed_by_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two that clear the same leftover, each as if the number were free."""
    monkeypatch.chdir(tmp_path)
    with new_folder(None, False) as place:
        (place.target / "mine").touch()
        (place.folder / "theirs").touch()
    assert place.folder == Path("runs/0002")
    assert names(tmp_path / "runs") == ["0001", "0002"]
    assert names(place.folder) == ["mine"]


def test_what_was_moved_aside_goes_back_where_nothing_replaced_it(tmp_path: Path) -> None:
    """A process that is killed between two renames."""
    aside = beside(tmp_path / "result", "replaced")
    dead = aside.with_name(aside.name.replace(f"-{os.getpid()}-", f"-{dead_process()}-"))
    dead.mkdir()
    (dead / "old").touch()
    clear_leftovers(tmp_path)
    assert names(tmp_path) == ["result"]
    assert names(tmp_path / "result") == ["old"]


def test_what_a_living_process_or_another_computer_has_begun_stays(tmp_path: Path) -> None:
    mine = beside(tmp_path / "a.nc")
    assert mine.suffix == ".nc"
    dead = mine.with_name(mine.name.replace(f"-{os.getpid()}-", f"-{dead_process()}-"))
    theirs = dead.with_name(dead.name.replace(f"-{_host()}-", "-00000000-"))
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        living = mine.with_name(mine.name.replace(f"-{os.getpid()}-", f"-{other.pid}-"))
        for path in (mine, dead, theirs, living):
            path.touch()
        clear_leftovers(tmp_path)
        other.communicate(b"\n")
    assert names(tmp_path) == sorted(path.name for path in (mine, theirs, living))


def test_a_process_that_ends_at_once_removes_what_it_has_begun(tmp_path: Path) -> None:
    with new_folder(tmp_path / "result", False) as place:
        assert place.target in HELD
        remove_all()
        assert not place.target.exists()
        place.target.mkdir()
    assert not HELD


def dead_process() -> int:
    """The number of a process that is gone."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_file_that_will_not_fit_is_refused_before_it_is_written(tmp_path: Path) -> None:
    """A limit of the process's files stands for a full disk, which HDF5 does not survive."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    path = tmp_path / "result.nc"
    check_room(path, 10**6)
    assert not list(tmp_path.iterdir())
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (10**7, before[1]))
        with pytest.raises(OSError, match=r"File too large; 1\d+ bytes are needed"):
            check_room(path, 10**8)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())

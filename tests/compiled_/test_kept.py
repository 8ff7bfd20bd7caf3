"""Compiled code is kept by what it is, wherever its source lies, and by whichever thread compiles it."""

import errno
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numba
import pytest

import ehamj.compiled
from ehamj.compiled import kept, kernel
from ehamj.compiled.told import telling
from ehamj.errors import Recompiled

SIMULATE = (
    "import ehamj, ehamj.compiled.kept as kept; "
    "from ehamj.mujoco.callbacks import callbacks; "
    "from numba.core import event; "
    "event.register('numba:compile', listener := event.RecordingListener()); "
    "callbacks(); print(len(listener.buffer))"
)
"""Prints how much was compiled for the callbacks."""


def compilations(package: Path, cache: Path) -> int:
    environment = {**os.environ, "EHAMJ_CACHE_DIR": str(cache), "PYTHONPATH": str(package.parent)}
    done = subprocess.run([sys.executable, "-c", SIMULATE], env=environment, capture_output=True, text=True, check=True)
    return int(done.stdout)


def test_another_copy_of_the_sources_with_other_comments_compiles_nothing_anew(tmp_path: Path) -> None:
    package = Path(ehamj.compiled.__file__).parents[1]
    copy = tmp_path / "elsewhere" / "ehamj"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__", "scenarios"))
    for file in ("isolator/edges.py", "mujoco/callbacks.py", "settings.py"):
        text = (copy / file).read_text(encoding="utf-8")
        (copy / file).write_text(
            text.replace('"""\n', '"""\n\n# A comment, which moves every line.\n', 1), encoding="utf-8"
        )
    cache = kept.cache_folder()
    assert cache is not None
    compilations(package, cache)  # unless an earlier test has
    assert compilations(copy, cache) == 0
    text = (copy / "isolator/edges.py").read_text(encoding="utf-8")
    (copy / "isolator/edges.py").write_text(text.replace("1e-300", "1e-299"), encoding="utf-8")
    shutil.copytree(cache, tmp_path / "cache")  # so that what compiles is not kept
    assert compilations(copy, tmp_path / "cache") > 0


def test_threads_that_compile_do_not_take_the_setting_from_each_other() -> None:
    before = numba.config.CACHE_LOCATOR_CLASSES
    seen: list[str] = []

    def compile_something(begun: threading.Event, finish: threading.Event) -> None:
        with kept._located(compile_something):
            begun.set()
            finish.wait(10.0)
            seen.append(numba.config.CACHE_LOCATOR_CLASSES)

    first, second, go = threading.Event(), threading.Event(), threading.Event()
    threads = [threading.Thread(target=compile_something, args=(begun, go)) for begun in (first, second)]
    threads[0].start()
    assert first.wait(10.0)
    threads[1].start()
    assert not second.wait(0.2)  # it waits for the first to leave
    go.set()
    for thread in threads:
        thread.join()
    assert seen == ["ehamj.compiled.kept.Locator"] * 2
    assert before == numba.config.CACHE_LOCATOR_CLASSES


def test_what_is_compiled_is_told_with_how_much_of_it_is_done() -> None:
    @kernel
    def twice(value: float) -> float:
        return 2.0 * value

    def fourfold(value):  # type: ignore[no-untyped-def]
        return twice(twice(value))

    seen: list[tuple[str, int, int]] = []
    with telling(lambda *words: seen.append(words)):
        assert numba.njit(fourfold)(1.5) == 6.0
    assert seen[0] == ("fourfold", 0, 2)
    assert seen[-1] == ("fourfold", 2, 2)
    del seen[:]
    with telling(lambda *words: seen.append(words)):
        pass
    numba.njit(fourfold)(1)
    assert not seen  # nobody listens any more


def _doubled(number: float) -> float:
    return 2.0 * number


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own for compiled code."""
    monkeypatch.setattr(kept, "cache_folder", lambda: tmp_path)
    return tmp_path


def doubling() -> dict[str, list[Path]]:
    """Double a number by compiled code, taken or made; and the files that it is kept in."""
    one = kept.compiled(_doubled, numba.float64(numba.float64))
    assert one(1.5) == 3.0
    found = (kept.cache_folder() or Path()).rglob("*.nb?")
    return {"taken": list(one.stats.cache_hits), "files": sorted(found)}


@pytest.mark.parametrize("damage", [lambda _: b"", lambda one: one[: len(one) // 2], lambda one: one[::-1]])
@pytest.mark.parametrize("which", [0, 1])
def test_kept_code_that_is_damaged_is_compiled_anew(place: Path, which: int, damage: Callable[[bytes], bytes]) -> None:
    """Cut off or garbled: understood, it would do anything, the end of the process included."""
    files = doubling()["files"]
    assert len(files) == 2
    assert doubling()["taken"]
    files[which].write_bytes(damage(files[which].read_bytes()))
    with pytest.warns(Recompiled, match=str(files[which])):
        again = doubling()
    assert not again["taken"]
    assert doubling()["taken"]


class Before(NamedTuple):
    value: float


class After(NamedTuple):
    value: float


def _value(one: Before | After) -> float:
    return one.value


def test_code_kept_by_a_version_with_other_names_is_compiled_anew(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a kept file names, such as the class of an argument, this version may not have."""
    assert kept.compiled(_value)(Before(1.0)) == 1.0
    monkeypatch.delattr(sys.modules[__name__], "Before")
    assert kept.compiled(_value)(After(2.0)) == 2.0
    assert list(place.rglob("*.nbi"))


def test_code_that_cannot_be_kept_runs(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(kept.caching.IndexDataCacheFile, "_save_data", full)
    assert not doubling()["taken"]

"""What is kept between runs has a place wherever there is one that is the user's alone."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from ehamj import caches


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The temporary folder of a user whose cache folder cannot be made, since a file is in its way."""
    (tmp_path / "home").write_text("", encoding="utf-8")
    monkeypatch.delenv("EHAMJ_CACHE_DIR", raising=False)
    monkeypatch.setattr(caches, "user_cache_path", lambda name: tmp_path / "home" / name)
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    caches.cache_folder.cache_clear()
    return tmp_path


@pytest.fixture(autouse=True)
def _as_it_was() -> Iterator[None]:
    yield
    caches.cache_folder.cache_clear()


def test_a_user_without_a_home_has_a_folder_of_his_own(temporary: Path) -> None:
    found = caches.cache_folder()
    assert found == temporary / f"ehamj-{os.getuid()}"
    assert found.stat().st_mode & 0o077 == 0
    caches.cache_folder.cache_clear()
    assert caches.cache_folder() == found  # the next run finds it


@pytest.mark.parametrize("how", ["shared", "link"])
def test_code_that_others_could_have_written_is_not_run(how: str, temporary: Path) -> None:
    place = temporary / f"ehamj-{os.getuid()}"
    if how == "shared":
        place.mkdir()
        place.chmod(0o777)
    else:
        (temporary / "theirs").mkdir()
        place.symlink_to(temporary / "theirs")
    assert caches.cache_folder() is None


def test_a_folder_that_is_named_is_the_only_one(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EHAMJ_CACHE_DIR", str(temporary / "home" / "named"))
    assert caches.cache_folder() is None
    caches.cache_folder.cache_clear()
    monkeypatch.setenv("EHAMJ_CACHE_DIR", str(temporary / "named"))
    assert caches.cache_folder() == temporary / "named"

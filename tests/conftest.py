"""Shared fixtures; also the rule that no test leaves a callback behind in MuJoCo."""

from collections.abc import Iterator

import pytest

from ehamj.native.hold import installed


@pytest.fixture(autouse=True)
def _no_callback_left_behind() -> Iterator[None]:
    yield
    assert not any(installed().values()), "a MuJoCo callback was left installed"

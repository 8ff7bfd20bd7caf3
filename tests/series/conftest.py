"""Blocks so short that what is long takes little time."""

from collections.abc import Callable

import pytest

from ehamj.series import grid, held, sampled


@pytest.fixture
def blocks_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Sets how many samples a block has."""

    def patch(samples: int) -> None:
        for module in (held, grid, sampled):
            monkeypatch.setattr(module, "BLOCK", samples)

    return patch


@pytest.fixture
def short_blocks(blocks_of: Callable[[int], None]) -> None:
    """Blocks of 1500 samples."""
    blocks_of(1500)

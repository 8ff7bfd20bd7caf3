"""What an object of a low room can do by rooms that stand far above it: `ehamj` puts it here, by name."""

from collections.abc import Callable
from typing import Any

ABOVE: dict[str, Callable[..., Any]] = {}
"""``save``, ``plot`` and ``replay`` of a result."""

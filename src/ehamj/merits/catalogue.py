"""All sources of merits, in the order in which they are listed: import it before names of merits are looked up."""

from ehamj.merits import (  # noqa: F401  # isort: skip
    actuator,
    passive,
    loop,
    run,
)
from ehamj.merits.merit import SOURCES

__all__ = ["SOURCES"]

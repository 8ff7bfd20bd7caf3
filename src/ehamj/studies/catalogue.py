"""The studies that `ehamj study` runs: each registers itself where it stands; they are listed in this order."""

from ehamj.studies import (  # noqa: F401  # isort: skip
    rocking,
    lateral,
    unequal,
    valve_oil,
    gains,
    failed,
    levels,
    tolerances,
    soft_mounts,
    waves,
)
from ehamj.studies.study import STUDIES

__all__ = ["STUDIES"]

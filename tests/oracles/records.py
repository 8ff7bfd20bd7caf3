"""What tests of readers share: a sine as a sensor feels it, and what became of a file."""

from pathlib import Path
from typing import Any

import numpy as np

from ehamj.ground import Motion, Start
from ehamj.ground.records import RecordGround
from ehamj.plant.mounts import MOUNTS
from ehamj.records.channel import Record
from ehamj.records.choices import Choices
from ehamj.records.readers import reader_of
from ehamj.scenario.load import anchored

POSITIONS = np.array([[0.9, 0.6], [0.9, -0.6], [-0.9, 0.6], [-0.9, -0.6]])
RATE = 500.0
TIMES = np.arange(5000) / RATE
NOISE = np.random.default_rng(3).standard_normal((3, 5000)) * 1e-5
SINE = 0.5 * np.sin(2 * np.pi * 20 * TIMES)


def read(path: Path, **choices: Any) -> Record:
    """The record of a file, by the reader that its name or its beginning chooses."""
    return reader_of(path).read(path, Choices(**choices))


def motion(folder: Path, file: str, **settings: Any) -> Motion:
    """What a scenario makes of a file."""
    table = anchored({"kind": "record", "file": file, **settings}, RecordGround, folder)
    return RecordGround(**table).motion(Start(MOUNTS, POSITIONS, 5.0, 1))


def by_axis(record: Record) -> dict[str, np.ndarray]:
    """Samples in SI by axis."""
    return {channel.axis: channel.samples for channel in record.channels}

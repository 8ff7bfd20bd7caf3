"""Files of measured modes: TOML, tables of text, universal files."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeVar

from pydantic import Field

from ehamj.errors import InputError
from ehamj.measured.mode_tables import read_mode_table
from ehamj.measured.mode_universal import read_mode_universal
from ehamj.measured.modes import Deviations, MeasuredModes, ModeEntry, ModeTable, listed, measured_modes
from ehamj.measured.nodes import Frame, Nodes, coordinates_of, places_of
from ehamj.measured.responses.reading import UNIVERSAL
from ehamj.measured.sensors import Place
from ehamj.scenario.explain import checked
from ehamj.scenario.model import Scenario
from ehamj.scenario_files import table_of
from ehamj.settings import Settings

ASSUMED = Deviations.stated(frequency=0.005, damping=0.2, shape=0.05)
"""Standard deviations where neither file nor user states any."""
WITHIN: Final = Frame()
"""Coordinates from the mount plane's centre, along the machine's axes."""

T = TypeVar("T")


class ModesFile(Settings):
    """A file of measured modes."""

    sensors: dict[str, Place] = Field(
        default_factory=dict,
        description="where each stood; without: called as a channel, as in foot_velocity front-left x",
    )
    deviation: Deviations = Field(ASSUMED, description="standard deviations of modes that state none")
    mode: tuple[ModeEntry, ...] = Field(description="modes", min_length=1)


def modes_of_file(
    path: Path,
    scenario: Scenario,
    places: Mapping[str, Place],
    deviation: Deviations | None = None,
    frame: Frame = WITHIN,
    nodes: Nodes | None = None,
) -> MeasuredModes:
    """The measured modes of a file.

    Args:
        path: of a TOML file (`ModesFile`), of a universal file with mode shapes (dataset 55), or of a table of text.
        scenario: whose feet and points sensors stand at.
        places: where sensors stood, beside what the file says.
        deviation: standard deviations of modes that state none; those of the file, or `ASSUMED`, without.
        frame: of a universal file's coordinates.
        nodes: where a universal file's nodes stood, before what it says itself.

    Raises:
        InputError: where it cannot be read, or a sensor has no place.
    """
    plant, points = scenario.plant, scenario.points
    if path.suffix.lower() in UNIVERSAL:
        return measured_modes(
            _universal(path, scenario, frame, nodes or {}), places, deviation or ASSUMED, plant, points
        )
    if nodes or frame != WITHIN:
        what = "nodes" if nodes else "frame"
        raise InputError(f"{what}: of use with universal files only, and {path.name!r} is none; leave it out")
    if path.suffix.lower() == ".toml":
        file = checked(ModesFile, table_of(path, "file of modes"))
        table = listed(file.mode, file.sensors, f"the file {path.name}")
        return measured_modes(table, places, deviation or file.deviation, plant, points)
    return measured_modes(_read(path, read_mode_table), places, deviation or ASSUMED, plant, points)


def _universal(path: Path, scenario: Scenario, frame: Frame, nodes: Nodes) -> ModeTable:
    """Modes of a universal file, with its nodes where they stood."""
    table, stood = _read(path, read_mode_universal), _read(path, coordinates_of)
    return replace(table, places=places_of(table.components, stood, frame, nodes, scenario.plant, scenario.points))


def _read(path: Path, reader: Callable[[Path], T]) -> T:
    """What a reader makes of a file; raises InputError where it cannot."""
    if not path.is_file():
        raise InputError(f"file = {str(path)!r}: there is no such file")
    try:
        return reader(path)
    except ValueError as error:
        raise InputError(str(error).replace("ground.file", "file")) from None

"""Files of measured modes: TOML, tables of text, universal files."""

from collections.abc import Mapping
from pathlib import Path

from pydantic import Field

from ehamj.errors import InputError
from ehamj.measured.mode_tables import read_mode_table
from ehamj.measured.modes import Deviations, MeasuredModes, ModeEntry, ModeTable, listed, measured_modes
from ehamj.measured.sensors import Place
from ehamj.scenario.explain import checked
from ehamj.scenario.model import Scenario
from ehamj.scenario_files import table_of
from ehamj.settings import Settings

ASSUMED = Deviations.stated(frequency=0.005, damping=0.2, shape=0.05)
"""Standard deviations where neither file nor user states any."""


class ModesFile(Settings):
    """A file of measured modes."""

    sensors: dict[str, Place] = Field(
        default_factory=dict,
        description="where each stood; without: called as a channel, as in foot_velocity front-left x",
    )
    deviation: Deviations = Field(ASSUMED, description="standard deviations of modes that state none")
    mode: tuple[ModeEntry, ...] = Field(description="modes", min_length=1)


def modes_of_file(
    path: Path, scenario: Scenario, places: Mapping[str, Place], deviation: Deviations | None = None
) -> MeasuredModes:
    """The measured modes of a file.

    Args:
        path: of a TOML file (`ModesFile`), of a universal file with mode shapes, or of a table of text.
        scenario: whose feet and points sensors stand at.
        places: where sensors stood, beside what the file says.
        deviation: standard deviations of modes that state none; those of the file, or `ASSUMED`, without.

    Raises:
        InputError: where it cannot be read, or a sensor has no place.
    """
    plant, points = scenario.plant, scenario.points
    if path.suffix.lower() == ".toml":
        file = checked(ModesFile, table_of(path, "file of modes"))
        table = listed(file.mode, file.sensors, f"the file {path.name}")
        return measured_modes(table, places, deviation or file.deviation, plant, points)
    return measured_modes(table_of_modes(path), places, deviation or ASSUMED, plant, points)


def table_of_modes(path: Path) -> ModeTable:
    """Modes of a table or a universal file, by the ending of its name.

    Raises:
        InputError: where it cannot be read.
    """
    if not path.is_file():
        raise InputError(f"file = {str(path)!r}: there is no such file")
    try:
        return read_mode_table(path)
    except ValueError as error:
        raise InputError(str(error)) from None

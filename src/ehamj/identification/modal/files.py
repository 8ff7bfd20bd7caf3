"""Files of measured modes: TOML, tables of text, universal files."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, Self, TypeVar

from pydantic import Field, model_validator

from ehamj.errors import InputError
from ehamj.identification.modal.responses import modes_in
from ehamj.identification.modal.universal import mobilities_of
from ehamj.measured.mode_tables import read_mode_table
from ehamj.measured.mode_universal import RESPONSES, SHAPES, datasets_of, read_mode_universal
from ehamj.measured.modes import Deviations, MeasuredModes, ModeEntry, ModeTable, listed, measured_modes
from ehamj.measured.nodes import Frame, Nodes, coordinates_of, places_of
from ehamj.measured.responses.reading import UNIVERSAL
from ehamj.measured.sensors import Place
from ehamj.scenario.explain import checked
from ehamj.scenario.load import anchored
from ehamj.scenario.model import Scenario
from ehamj.scenario_files import table_of
from ehamj.settings import Band, FileName, Settings

ASSUMED = Deviations.stated(frequency=0.005, damping=0.2, shape=0.05)
"""Standard deviations where neither file nor user states any."""
WITHIN: Final = Frame()
"""Coordinates from the mount plane's centre, along the machine's axes."""
NODES_SAID: Final = (
    "where nodes of a universal file stood, by their numbers: a foot, a point of the scenario, or a place from the "
    "mount plane's centre [m]; without: as the file has them"
)
BAND_SAID: Final = "of a universal file's responses, lines that count; without: all [Hz]"

T = TypeVar("T")


class ModesFile(Settings):
    """A file of measured modes, or what there is to say of another one."""

    sensors: dict[str, Place] = Field(
        default_factory=dict,
        description="where each stood; without: called as a channel, as in foot_velocity front-left x",
    )
    deviation: Deviations | None = Field(None, description="standard deviations of modes that state none")
    mode: tuple[ModeEntry, ...] = Field((), description="modes")
    file: FileName | None = Field(None, description="instead: a universal file, or a table of modes")
    nodes: Nodes = Field(default_factory=dict, description=NODES_SAID)
    frame: Frame = Field(WITHIN, description="how the coordinates of a universal file lie in the machine")
    band: Band | None = Field(None, description=BAND_SAID)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (not self.mode):
            raise ValueError("must have mode, or file")
        if self.file is not None and Path(self.file).suffix.lower() == ".toml":
            raise ValueError(f"file = {self.file!r}: must be a universal file or a table, not TOML as well")
        stray = next((name for name in ("nodes", "frame", "band") if name in self.model_fields_set), None)
        if self.file is None and stray is not None:
            raise ValueError(f"{stray}: says something of a universal file; name it, file = …")
        return self


def modes_of_file(
    path: Path,
    scenario: Scenario,
    places: Mapping[str, Place],
    deviation: Deviations | None = None,
    frame: Frame = WITHIN,
    nodes: Nodes | None = None,
    band: Band | None = None,
) -> MeasuredModes:
    """The measured modes of a file.

    Args:
        path: of a TOML file (`ModesFile`), of a universal file with mode shapes (dataset 55) or frequency responses of
            motions to forces (58), in which modes are found (`modes_in`), or of a table of text.
        scenario: whose feet and points sensors stand at.
        places: where sensors stood, beside what the file says.
        deviation: standard deviations of modes that state none; those of the file, or `ASSUMED`, without.
        frame: of a universal file's coordinates.
        nodes: where a universal file's nodes stood, before what it says itself.
        band: of frequency responses that count [Hz]; None: all.

    Raises:
        InputError: where it cannot be read, or a sensor has no place.
    """
    plant, points = scenario.plant, scenario.points
    if path.suffix.lower() in UNIVERSAL:
        table = _universal(path, scenario, frame, nodes or {}, band)
        return measured_modes(table, places, deviation or ASSUMED, plant, points)
    if nodes or frame != WITHIN or band is not None:
        what = "nodes" if nodes else "frame" if frame != WITHIN else "band"
        raise InputError(f"{what}: of use with universal files only, and {path.name!r} is none; leave it out")
    if path.suffix.lower() == ".toml":
        file = checked(ModesFile, anchored(table_of(path, "file of modes"), ModesFile, path.resolve().parent))
        said = deviation or file.deviation
        if file.file is not None:
            every = {**file.sensors, **places}
            return modes_of_file(Path(file.file), scenario, every, said, file.frame, file.nodes, file.band)
        table = listed(file.mode, file.sensors, f"the file {path.name}")
        return measured_modes(table, places, said or ASSUMED, plant, points)
    return measured_modes(_read(path, read_mode_table), places, deviation or ASSUMED, plant, points)


def _universal(path: Path, scenario: Scenario, frame: Frame, nodes: Nodes, band: Band | None) -> ModeTable:
    """Modes of a universal file, with its nodes where they stood: as it has them, else those in its responses."""
    held = _read(path, datasets_of)
    if SHAPES in held or RESPONSES not in held:
        if band is not None:
            raise InputError(f"band: {path.name!r} holds mode shapes, and no responses are asked for; leave it out")
        table = _read(path, read_mode_universal)
    else:
        table = modes_in(_read(path, lambda own: mobilities_of(own, band)))
    stood = _read(path, coordinates_of)
    return replace(table, places=places_of(table.components, stood, frame, nodes, scenario.plant, scenario.points))


def _read(path: Path, reader: Callable[[Path], T]) -> T:
    """What a reader makes of a file; raises InputError where it cannot."""
    if not path.is_file():
        raise InputError(f"file = {str(path)!r}: there is no such file")
    try:
        return reader(path)
    except ValueError as error:
        raise InputError(str(error).replace("ground.file", "file")) from None

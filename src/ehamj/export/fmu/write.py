"""A subject packed as a unit: its scenario with all files, its law, a script, and PythonFMU's binaries."""

import importlib
import shutil
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final
from zlib import crc32

import tomli_w

from ehamj.errors import InputError
from ehamj.export.fmu.interface import identifier
from ehamj.export.fmu.unit import GIVEN, LAW, SCENARIO, Unit
from ehamj.export.subject import Subject
from ehamj.export.written import Written
from ehamj.extras import check_extra

OPENS: Final = "open it in Simulink, Dymola, OpenModelica, or with: fmpy simulate {path}"
NEEDS: Final = (
    "the unit runs in a Python of the host's (x86-64, Linux or Windows), {python}, which must find ehamj {ehamj}; "
    "Windows finds the Python on the PATH; on Linux a host that is no Python itself is started with {linux}"
)
HELD: Final = (
    "inputs are held between communication points, which are multiples of the timestep; the ground's is an "
    "acceleration, integrated to velocity and displacement"
)
SCRIPT: Final = '''\
"""{title}: a unit for co-simulation, written by ehamj {ehamj}."""

import sys
from pathlib import Path

import pythonfmu
from pythonfmu import Fmi2Slave

VERSION, PLACES = {python!r}, {places!r}


def from_ehamj():
    """What runs the unit: of the ehamj that this Python has, or else of the one that wrote the unit."""
    try:
        import ehamj
    except ImportError:
        if sys.version_info[:2] == VERSION:
            sys.path.extend(place for place in PLACES if place not in sys.path)
    try:
        from ehamj.export.fmu import slave, unit
    except ImportError as error:
        raise ImportError(
            f"ehamj: is not installed ({{error}}) in the Python {{sys.version.split()[0]}} that the host found in "
            f"{{sys.prefix}}; pip install 'ehamj=={ehamj}' there, or let the host find the Python that has it"
        ) from None
    return slave, unit


class {name}(Fmi2Slave):
    author = "ehamj {ehamj}"
    description = {description!r}

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.slave, unit = from_ehamj()
        self.unit = unit.Unit(Path(self.resources))
        self.slave.register(self, self.unit, pythonfmu)
        self.default_experiment = pythonfmu.DefaultExperiment(0.0, {stop!r}, {step!r}, None)

    def to_xml(self, model_options={{}}):
        return self.slave.describe(super().to_xml(model_options), self.unit)

    def setup_experiment(self, start_time, stop_time=None, tolerance=None):
        self.unit.experiment(start_time, stop_time)

    def exit_initialization_mode(self):
        self.slave.told(self.unit.begin)

    def do_step(self, current_time, step_size):
        self.slave.told(self.unit.step, current_time, step_size)
        return True

    def terminate(self):
        self.unit.close()
'''


def write_fmu(subject: Subject, path: Path) -> Written:
    """Write the unit; it holds all files of its scenario.

    Raises:
        InputError: if PythonFMU is not installed, or the scenario cannot be stepped from outside.
    """
    check_extra("pythonfmu", f"--fmu {path.name!r}")
    scenario = subject.scenario
    if scenario.engine != "mujoco":
        raise InputError(f"--fmu: engine = {scenario.engine!r} steps whole runs only; --set engine=mujoco")
    name = identifier(subject.name)
    parts = path.parent / "parts"  # goes with the folder that the unit is written in
    parts.mkdir()
    files = [*_pack(subject, parts)]
    step = max(1, round(1.0 / (scenario.record_rate * subject.timestep))) * subject.timestep
    text = SCRIPT.format(
        name=name, title=scenario.name.replace('"', "'").replace("\\", "/"), ehamj=version("ehamj"),
        python=sys.version_info[:2], places=_places(), description=scenario.description or scenario.name,
        stop=scenario.duration, step=step,
    )  # fmt: skip
    script = parts / f"ehamj_{name}_{crc32(b''.join(one.read_bytes() for one in files) + text.encode()):08x}.py"
    script.write_text(text, encoding="utf-8")
    try:
        with _importing(script):
            from pythonfmu.builder import FmuBuilder

            options = {"canHandleVariableCommunicationStepSize": True, "canGetAndSetFMUstate": False}
            FmuBuilder.build_FMU(script, path, files, _documented(subject, parts), **options)
    finally:
        shutil.rmtree(parts)
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    needs = NEEDS.format(python=python, ehamj=version("ehamj"), linux=_before(python))
    said = f"the machine as a unit for co-simulation, FMI 2.0, timestep {1e6 * subject.timestep:.6g} µs; {OPENS}"
    return Written({path.name: said}, (HELD, needs))


def _before(python: str) -> str:
    """What stands before the command of a host on Linux that brings no Python of its own."""
    name = sysconfig.get_config_var("INSTSONAME") or ""
    library = Path(sysconfig.get_config_var("LIBDIR") or "") / name
    shared = library if ".so" in name and library.is_file() else f"libpython{python}.so.1.0"
    return f"LD_PRELOAD={shared} PYTHONHOME={sys.base_prefix}"


def _places() -> list[str]:
    """Where this Python finds packages."""
    return [place for place in sys.path if place and Path(place).is_absolute()]


@contextmanager
def _importing(script: Path) -> Iterator[None]:
    """Within, a script may be imported; afterwards nothing of it is left."""
    before = list(sys.path)
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = before
        sys.modules.pop(script.stem, None)


def _pack(subject: Subject, parts: Path) -> Iterator[Path]:
    """Scenario, its files and its law in a folder; yields what is there."""
    files: dict[str, str] = {}
    table = _packed(subject.scenario.model_dump(mode="python", exclude_none=True), parts, files)
    (parts / SCENARIO).write_text(tomli_w.dumps(table), encoding="utf-8")
    yield parts / SCENARIO
    yield from (parts / name for name in files.values())
    law = subject.controller
    if law is not None:
        law.save(parts / LAW)
        yield parts / LAW
    if law is not None and (subject.folder is not None or subject.scenario.control.kind == "law"):
        (parts / GIVEN).write_text("", encoding="utf-8")
        yield parts / GIVEN


def _packed(value: Any, parts: Path, files: dict[str, str]) -> Any:
    """A table whose files are copied, and named, within a folder; ``files`` gets their names by where they were."""
    if isinstance(value, dict):
        return {key: _packed(entry, parts, files) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [_packed(entry, parts, files) for entry in value]
    if not isinstance(value, str) or not Path(value).is_absolute() or not Path(value).is_file():
        return value
    if value not in files:
        files[value] = f"file-{len(files) + 1}-{Path(value).name}"
        shutil.copyfile(value, parts / files[value])
    return files[value]


def _documented(subject: Subject, parts: Path) -> Path:
    """A folder with the unit's page."""
    unit, folder = Unit(parts), parts / "documentation"
    folder.mkdir()
    rows = "".join(
        f"<tr><td>{escape(one.name)}</td><td>{one.role}</td><td>{escape(one.unit)}</td><td>{escape(one.text)}</td></tr>"
        for one in unit.variables
    )
    head = f"<meta charset='utf-8'><title>{escape(subject.scenario.name)}</title>"
    about = f"<p>{escape(subject.scenario.description)}</p><p>{escape(HELD[0].upper() + HELD[1:])}.</p>"
    table = f"<table><tr><th>name</th><th>role</th><th>unit</th><th>what it is</th></tr>{rows}</table>"
    (folder / "index.html").write_text(
        f"<!doctype html><html lang='en'>{head}<h1>{escape(subject.scenario.name)}</h1>{about}{table}</html>",
        encoding="utf-8",
    )
    return folder

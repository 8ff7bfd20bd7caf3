"""A subject packed as a unit: its scenario with all files, its law, a script, and PythonFMU's binaries."""

import importlib
import shutil
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import Final
from zlib import crc32

import tomli_w

from ehamj.errors import InputError
from ehamj.export.fmu.interface import identifier
from ehamj.export.fmu.unit import GIVEN, LAW, SCENARIO, Unit
from ehamj.export.subject import Subject
from ehamj.export.written import Written
from ehamj.extras import check_extra
from ehamj.records.files import named_by
from ehamj.scenario.load import named_anew
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import stated

OPENS: Final = "open it in Simulink, Dymola, OpenModelica, or with: fmpy simulate {path}"
NEEDS: Final = (
    "the unit runs in a Python of the host's (x86-64, Linux or Windows), {python}, which must find ehamj {ehamj}, or "
    "else takes it from {places}, which the unit names; "
    "Windows finds the Python on the PATH; on Linux a host that is no Python itself is started with {linux}"
)
HELD: Final = (
    "inputs are held between communication points, which are multiples of the timestep; the ground's is an "
    "acceleration, integrated to velocity and displacement"
)
SCRIPT: Final = '''\
"""{title}: a unit for co-simulation, written by ehamj {ehamj}."""

import site
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
            for place in PLACES:
                site.addsitedir(place)
    try:
        from ehamj.export.fmu import slave, unit
    except ImportError as error:
        raise ImportError(
            f"ehamj: is not installed ({{error}}) in the Python {{sys.version.split()[0]}} that the host found in "
            f"{{sys.prefix}}; pip install 'ehamj=={ehamj}' there, or let the host find the Python that has it"
        ) from None
    return slave, unit


class EhamjUnit(Fmi2Slave):
    author = "ehamj {ehamj}"
    description = {description!r}

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.modelName = {name!r}
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
        return self.slave.stepped(self, self.unit, pythonfmu, current_time, step_size)

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
    script = parts / f"ehamj_{name}_{crc32(_content(files) + text.encode()):08x}.py"
    script.write_text(text, encoding="utf-8")
    try:
        with _importing(script):
            from pythonfmu.builder import FmuBuilder

            options = {"canHandleVariableCommunicationStepSize": True, "canGetAndSetFMUstate": False}
            FmuBuilder.build_FMU(script, path, files, _documented(subject, parts), **options)
    finally:
        shutil.rmtree(parts)
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    places = " and ".join(_places())
    needs = NEEDS.format(python=python, ehamj=version("ehamj"), places=places, linux=_before(python))
    said = f"the machine as a unit for co-simulation, FMI 2.0, timestep {1e6 * subject.timestep:.6g} µs; {OPENS}"
    return Written({path.name: said}, (HELD, needs))


def _before(python: str) -> str:
    """What stands before the command of a host on Linux that brings no Python of its own."""
    name = sysconfig.get_config_var("INSTSONAME") or ""
    library = Path(sysconfig.get_config_var("LIBDIR") or "") / name
    shared = library if ".so" in name and library.is_file() else f"libpython{python}.so.1.0"
    return f"LD_PRELOAD={shared} PYTHONHOME={sys.base_prefix}"


def _places() -> list[str]:
    """Where this Python's own packages are installed; where else it looks is nobody's business."""
    return [*dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib"))]


def _content(files: Iterable[Path]) -> bytes:
    """Of files and of all within folders."""
    within = (each for one in files for each in (sorted(one.rglob("*")) if one.is_dir() else [one]))
    return b"".join(each.read_bytes() for each in within if each.is_file())


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
    """Scenario, its files and its law in a folder; yields files and folders that are there."""
    files = _Files(parts)
    table = named_anew(stated(subject.scenario), Scenario, files.packed)
    (parts / SCENARIO).write_text(tomli_w.dumps(table), encoding="utf-8")
    yield parts / SCENARIO
    yield from files.folders
    law = subject.controller
    if law is not None:
        law.save(parts / LAW)
        yield parts / LAW
    if law is not None and (subject.folder is not None or subject.scenario.control.kind == "law"):
        (parts / GIVEN).write_text("", encoding="utf-8")
        yield parts / GIVEN


class _Files:
    """Copies of the files that a scenario names, in a folder: each name's in a folder of its own, called as they are,
    since a record's components may be told apart by their files' names."""

    def __init__(self, parts: Path) -> None:
        self._parts = parts
        self._known: dict[str, str] = {}
        self.folders: list[Path] = []

    def packed(self, name: str) -> str:
        """The name, within the folder, of the copies of the files that an absolute one means.

        Raises:
            InputError: if there are none.
        """
        if not Path(name).is_absolute():
            return name  # packed before
        if name not in self._known:
            files = named_by(Path(name))
            if not files:
                raise InputError(
                    f"--fmu: the scenario names {name!r}, and there is no such file to pack; mend or drop it"
                )
            folder = self._parts / f"file-{len(self.folders) + 1}"
            folder.mkdir()
            for one in files:
                shutil.copyfile(one, folder / one.name)
            self.folders.append(folder)
            self._known[name] = f"{folder.name}/{Path(name).name}"
        return self._known[name]


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

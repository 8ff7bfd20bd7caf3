"""The formats that a subject is exported to, by name."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

from ehamj.export.fmu.write import write_fmu
from ehamj.export.law_c import MARKS, write_c
from ehamj.export.matlab import script_of, write_matlab
from ehamj.export.mjcf import write_mjcf
from ehamj.export.python_control import write_python_control
from ehamj.export.subject import Subject
from ehamj.export.written import Written
from ehamj.registry import Registry


def _alone(target: Path) -> tuple[Path, ...]:
    return ()


class Format(NamedTuple):
    """One format; a variant of it is one of its own, with an option of its own."""

    option: str
    """Of the command line, such as ``--mjcf``."""
    takes: str
    """What follows it: ``FILE.xml``, of which the suffix is demanded, or ``FOLDER``."""
    what: str
    """What is written, one line, for help and pages."""
    write: Callable[[Subject, Path], Written]
    """Writes the file, or into the folder, which is there and empty. Neither stands in its place yet: that it takes
    when every format that was asked for is whole (`ehamj.export.placed`)."""
    marks: tuple[str, ...] = ()
    """Of a folder: files without which one that is there is not replaced."""
    beside: Callable[[Path], tuple[Path, ...]] = _alone
    """Of a file: further ones that are written next to it, of which `Written.files` tells too."""

    @property
    def suffix(self) -> str:
        """Of the file; empty of a folder."""
        return Path(self.takes).suffix

    @property
    def parameter(self) -> str:
        """The option as the name of a Python parameter."""
        return self.option.lstrip("-").replace("-", "_")


FORMATS: Final[Registry[Format]] = Registry("format")
FORMATS.add(
    "matlab",
    Format("--matlab", "FILE.mat", "plant and law as structs for MATLAB and Octave", write_matlab, beside=script_of),
)
FORMATS.add(
    "python-control",
    Format("--python-control", "FILE.json", "plant and law as arguments of control.ss, in JSON", write_python_control),
)
FORMATS.add(
    "mjcf", Format("--mjcf", "FILE.xml", "the machine as a MuJoCo model, to look at or to build on", write_mjcf)
)
FORMATS.add("c", Format("--c", "FOLDER", "the law in C99, with a run's readings to replay", write_c, MARKS))
FORMATS.add("fmu", Format("--fmu", "FILE.fmu", "the nonlinear machine as a unit for co-simulation, FMI 2.0", write_fmu))

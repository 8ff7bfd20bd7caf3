"""The machine as MJCF: what MuJoCo knows of it."""

from importlib.metadata import version
from pathlib import Path
from typing import Final

from ehamj.export.subject import Subject
from ehamj.export.written import Written
from ehamj.mujoco.model import drawn_xml

OPENS: Final = "open it with: python -m mujoco.viewer --mjcf={path}, or in any tool that reads MJCF"
NOT_IN_IT: Final = (
    "an MJCF holds bodies, plates and membranes; oil, valves, sensors and law are not in it, so that the "
    "machine stands on its membranes alone; numbers have the six digits that MuJoCo writes"
)


def write_mjcf(subject: Subject, path: Path) -> Written:
    """Write the model that a run steps, drawn, as one file that needs no other; as ``model.xml`` of a result."""
    text = drawn_xml(subject.scenario.plant, subject.timestep)
    head = f"<!-- ehamj {version('ehamj')}, scenario {subject.name}: {NOT_IN_IT} -->\n"
    path.write_text(head + text + "\n", encoding="utf-8")
    return Written({path.name: f"the machine as MJCF; {OPENS}"}, (NOT_IN_IT,))

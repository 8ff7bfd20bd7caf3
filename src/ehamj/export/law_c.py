"""The law as C99, from the readings to the valves' commands, for a real-time target."""

from pathlib import Path
from typing import Final

from ehamj.export.subject import Subject
from ehamj.export.written import Written

MARKS: Final = ("ehamj_law.h", "ehamj_law.c")
"""Without which a folder is not one of these."""


def write_c(subject: Subject, folder: Path) -> Written:
    """Write the law, what its sensors read and what it commands in a run, and a program that replays that.

    Raises:
        InputError: if there is no law, or one that C cannot have.
    """
    from ehamj.export.c.write import write_law

    clock, found = write_law(subject.scenario, subject.controller, subject.timestep, subject.name, folder)
    notes = [f"the commands of a step are to reach the valves {clock.rest_said}"]
    if found.failed:
        notes.append(f"the run that the vectors come from failed; they end after {len(found.readings)} ticks")
    own, shown = subject.controller, len(found.readings) * clock.period
    if own is not None and shown < own.converter.switch_on + own.converter.fade:
        notes.append(
            f"the vectors end at {shown:g} s, before the commands have faded in (control.switch_on, control.fade)"
        )
    said = {
        "ehamj_law.c": "the law in C99; ehamj_law.h is what you call",
        "vectors.csv": f"{len(found.readings)} ticks of a run; main.c replays them: make && ./replay in its folder",
        "README.txt": "how to run it on a target, and to measure its time",
    }
    return Written(said, tuple(notes))

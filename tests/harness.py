"""What tests of several rooms share: what the command line said, and a machine on mounts in any direction."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple


class Said(NamedTuple):
    """Exit code, standard output, standard error."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The single JSON object that is all of standard output."""

        def refuse(constant: str) -> None:
            raise AssertionError(f"{constant} is no JSON")

        found = json.loads(self.out, parse_constant=refuse)  # fails on anything after the object
        assert isinstance(found, dict)
        return found

    @property
    def message(self) -> str:
        """The one message of a refusal: nothing on standard output, no traceback."""
        assert (self.code, self.out) == (2, "")
        assert "Traceback" not in self.err
        (found,) = re.findall(r"^ehamj: (.*)$", self.err, re.MULTILINE)
        return str(found)


Cli = Callable[..., Said]

SKEW_MOUNTS: list[dict[str, Any]] = [
    {"name": "a", "position": [0.8, 0.1, 0.5], "direction": [0.2, 0.1, 1.0]},
    {"name": "b", "position": [-0.7, 0.6, -0.5], "direction": [-0.3, 0.4, 1.0], "height": 0.002},
    {"name": "c", "position": [-0.6, -0.7, 0.0], "direction": [0.0, -1.0, 0.3]},
    {"name": "d", "position": [0.5, -0.6, 0.2]},
    {"name": "level", "position": [0.9, 0.5, 0.4], "direction": [-1.0, 0.0, 0.0]},
]
"""Five mounts off the plane: two skew, one of them shimmed, one that leans over, one upright, one level."""


def sealed_anew(folder: Path, change: Callable[[dict[str, Any]], Any] = lambda summary: None) -> None:
    """Let the summary believe that the files beside it are those that its run wrote."""
    from ehamj.belonging import summary_text, told

    found = told(folder)
    change(found.summary)
    text = summary_text(found.summary, found.belongs.run, folder, found.belongs.files, found.belongs.variants)
    (folder / "summary.json").write_text(text)

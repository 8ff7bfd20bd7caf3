"""What the command line said, for the tests of every room that has a command."""

import json
import re
from collections.abc import Callable
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

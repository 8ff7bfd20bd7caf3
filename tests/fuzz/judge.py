"""What is wrong with the outcome of a case, as one line each that is the same for the same fault."""

import re
from collections.abc import Iterator
from typing import Any, Final

from ehamj.scenario.model import Scenario
from ehamj.unfinished import _NAME as UNFINISHED

SLOWEST: Final = 2.0
"""Time of the processor within which a refusal is said [s]."""
MOST: Final = 300.0
"""Memory that a refusal may take beyond an idle process [MiB]."""
LONGEST: Final = 5000
"""Length of what is said of a refusal."""
LINES: Final = 30
"""A message has a line per key that is wrong, a table drawn at random may have some."""
USUAL: Final = (
    "simulating ",
    "compiling ",
    "writing",
    "measuring",
    "drawing ",
    "building ",
    "note: ",
    "finding ",
    "deriving ",
)
"""Lines that tell what is being done, before a message."""
CODES: Final = (0, 2, 3, 130)

PLACES: Final = (
    "--set",
    "--out",
    "controller",
    "result",
    "scenario",
    "mount",
    "study",
    "design",
    *Scenario.model_fields,
)
"""What a message may begin with beside the keys of a case: the tables of a scenario."""


def findings(kind: str, outcome: dict[str, Any]) -> Iterator[str]:
    """Everything that is wrong, each by a signature."""
    codes, said = outcome["codes"], outcome["said"]
    code = codes[-1]
    if code not in CODES:
        yield f"exit code {code}: {_first(said)}"
    if "Traceback (most recent call last)" in said:
        yield f"traceback: {_last(said)}"
    if "should not happen" in said:
        yield f"unforeseen: {same(_message(said))}"
    warning = re.search(r"^\S+:\d+: (\w*Warning): (.*)$", said, re.MULTILINE)
    if warning:
        yield f"warning: {warning[1]} {same(warning[2])}"
    beyond = re.search(r"^note: somewhere numbers are .*\((.*)\)$", said, re.MULTILINE)
    if beyond:
        yield f"beyond numbers: {same(beyond[1])}"
    if outcome["executed"]:
        yield f"executed: {outcome['executed'][0][:60]}"
    if outcome["whole"]:
        yield f"result: {same(outcome['whole'])[:120]}"
    if kind == "signal":
        yield from _ended(outcome)
        return
    if code == 2:
        yield from _refusal(outcome, said)
    unjudged = "could not be judged" in said  # the run is whole, and what cannot be said of it is named
    if code == 3 and not unjudged and "simulation failed" not in said and "should not happen" not in said:
        yield f"failure without its words: {same(_message(said) or _first(said))}"
    if code == 3 and not unjudged and outcome["complete"] and codes[:1] == [3]:
        yield "failed, and the result says complete"
    if code == 0 and outcome["complete"] is False:
        yield "done, and the result says incomplete"
    strange = [name for name in outcome["left"] if _strange(name)]
    if strange:
        yield f"left: {same(strange[0])}"


def _ended(outcome: dict[str, Any]) -> Iterator[str]:
    from fuzz.signals import LIMIT

    if outcome["codes"][-1] not in (0, 130):
        yield f"interrupted, it ends with {outcome['codes'][-1]}: {same(_message(outcome['said']))}"
    if (outcome["ended"] or 0.0) > LIMIT:
        yield f"it ended later than {LIMIT:g} s after it was asked to"


def _strange(name: str) -> bool:
    """Whether a file is none that a command is to leave."""
    first, *_, last = [*name.split("/"), name.split("/")[-1]]
    return (
        bool(UNFINISHED.fullmatch(last)) or first not in ("out", "runs", "result", "good") or last == "MUJOCO_LOG.TXT"
    )


def _refusal(outcome: dict[str, Any], said: str) -> Iterator[str]:
    messages = re.findall(r"^ehamj: ", said, re.MULTILINE)
    if len(messages) != 1:
        yield f"{len(messages)} messages: {_first(said)}"
    if len(said) > LONGEST or said.count("\n") > LINES:
        yield f"long message: {same(_message(said))[:80]}"
    before = said[: max(said.find("ehamj: "), 0)].splitlines()
    stray = [line for line in before if line.strip() and not line.startswith(USUAL)]
    if stray:
        yield f"beside the message: {same(stray[0])}"
    if outcome["seconds"][-1] > SLOWEST:
        yield f"slow refusal: {same(_message(said))[:100]}"
    if outcome["memory"][-1] > MOST:
        yield f"memory of a refusal: {same(_message(said))[:100]}"
    if outcome["left"] and len(outcome["codes"]) == 1:
        yield f"left by a refusal: {same(outcome['left'][0])}"
    if not named(outcome, said):
        yield f"unnamed: {same(_message(said))[:140]}"


def named(outcome: dict[str, Any], said: str) -> bool:
    """Whether the message names a key of what was changed, or of the tables that a scenario has; of damaged bytes the
    file and the place."""
    message = _message(said)
    own = {part for key in outcome["keys"] for part in re.split(r"[ .]", key) if len(part) > 1 and not part.isdigit()}
    if any(part in message for part in own) or message.startswith(tuple(PLACES)):
        return True
    if any(re.search(rf"\b{name}(\.\w| = |\[)", message) for name in PLACES):
        return True
    return bool(re.match(r"standard output|[\w.…-]+ = .*: unknown key; ", message))


def _message(said: str) -> str:
    found = re.search(r"^ehamj: (.*)", said, re.MULTILINE)
    return found[1] if found else ""


def _first(said: str) -> str:
    return same(next((line for line in said.splitlines() if line.strip()), "nothing said"))


def _last(said: str) -> str:
    """The type of an error that was shown whole, and where in ehamj it came from."""
    at = said.find("Traceback (most recent call last)")
    text = said[at:]
    ours = re.findall(r'File ".*?/ehamj/(\S+)", line \d+, in (\S+)', text)
    error = re.findall(r"^(\w[\w.]*(?:Error|Exception|Interrupt)\b.*)$", text, re.MULTILINE)
    return f"{same(error[0]) if error else '?'} at {ours[-1] if ours else '?'}"


def same(text: str) -> str:
    """A message without its numbers and names, which differ from case to case."""
    text = re.sub(r"'/\S*?'|\"/\S*?\"|/tmp/\S+", "FILE", text)
    text = re.sub(r"'[^']{0,300}'", "'…'", text)
    text = re.sub(r"(?<![A-Za-z_])[-+]?\d[\d.]*(e[-+]?\d+)?", "#", text)
    text = re.sub(r"\[[^\[\]]*\]", "[…]", text)
    text = re.sub(r"= .*?:", "= …:", text, count=1)
    return text[:200]

"""Which files belong to one run: the identity that each carries, and a digest of what each held when it was written.

The identity is a digest of what a run came from and of where it ended: its scenario, versions, and the last row of
every variable, in which a law shows too. So the same run comes out with the same identity and the same files, to the
bit, and any other with another. It stands in a last line of ``scenario.toml`` and ``model.xml``, as ``run`` in
``controller.json`` and among the attributes of ``result.nc``, and at the
beginning of ``report.html`` and ``replay.rrd``. ``summary.json`` has it in its table ``belongs``, with
the digest of every file (as ``sha256sum`` prints it), of the summary itself, and the identities of the variants that
ran beside it.
"""

import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from ehamj.errors import InputError
from ehamj.findings import Finding
from ehamj.folders import RESULT_FILES
from ehamj.interruption import check
from ehamj.plain.text import json_of

if TYPE_CHECKING:
    import xarray as xr

SUMMARY: Final = "summary.json"
HISTORIES: Final = "result.nc"
KEY: Final = "belongs"
"""Of the table in a summary's file."""
RUN: Final = "run"
"""Key and attribute that hold the identity elsewhere."""

COMMENTS: Final = {"scenario.toml": "# of run {}\n", "model.xml": "<!-- of run {} -->\n"}
_CARRIED: Final = re.compile(rb'(?:of run |"run": ?")([0-9a-f]{32})\b')
CARRYING: Final = ("scenario.toml", "model.xml", "controller.json", HISTORIES)
"""Files that carry the identity, if they are there, beside the summary's."""
SHOWING: Final = {"report.html": "report", "replay.rrd": "replay"}
"""Files that show a run, and carry its identity at their beginning, each with the command that makes it anew."""
BEGINNING: Final = 2**20
"""Of such a file [B]; a recording's layout stands first."""
PIECE: Final = 2**22
"""Of a file that is read at once for its digest [B]."""


class Belongs(Finding):
    """What a summary's file says of the files beside it."""

    run: str
    """The identity."""
    files: dict[str, str]
    """Digest of each."""
    variants: dict[str, str]
    """Identity of each variant that ran beside it, by its folder."""
    rest: str
    """Digest of all else that the summary's file holds."""


class Told(NamedTuple):
    """A result's folder as its summary's file tells it."""

    folder: Path
    summary: dict[str, Any]
    belongs: Belongs


def identity_of(source: str, versions: Mapping[str, str], dataset: "xr.Dataset") -> str:
    """The identity of a run.

    Args:
        source: what it came from.
        versions: of what it ran on.
        dataset: its histories, of which the last row is read.
    """
    rows = dataset.sizes["time"]
    found = hashlib.blake2b(f"{source}\n{json.dumps(versions, sort_keys=True)}\n{rows}".encode(), digest_size=16)
    for name in sorted(map(str, dataset.data_vars) if rows else ()):
        found.update(name.encode() + dataset[name][rows - 1].values.tobytes())
    return found.hexdigest()


def marked(name: str, text: str, run: str) -> str:
    """The text of a file with the identity in it."""
    if name in COMMENTS:
        return f"{text}\n{COMMENTS[name].format(run)}"
    return text.replace("{", f'{{\n "{RUN}": "{run}",', 1)


def shown_mark(runs: Iterable[str]) -> str:
    """What stands at the beginning of a file that shows runs of these identities: the first, and a digest of all."""
    runs = list(runs)
    return f"of run {runs[0]} {hashlib.blake2b(' '.join(runs).encode(), digest_size=4).hexdigest()}"


def unmarked(name: str, text: str, run: str) -> str:
    """The inverse of `marked`, where a comment holds the identity."""
    return text.removesuffix(f"\n{COMMENTS[name].format(run)}")


def summary_text(
    summary: Mapping[str, Any], run: str, folder: Path, names: Iterable[str], variants: Mapping[str, str]
) -> str:
    """The text of a summary's file, of a folder where all others are written: those with these names."""
    files = {name: digest_of(folder / name) for name in names}
    told = Belongs(run=run, files=files, variants=dict(variants), rest=_rest(summary))
    return json.dumps({KEY: told.to_dict(), **summary}, indent=2, allow_nan=False) + "\n"


def told(folder: Path) -> Told:
    """A result's folder as its summary's file tells it, checked against nothing yet.

    Raises:
        InputError: if the file is damaged, or was written before results carried an identity.
    """
    whose = f"result {str(folder)!r}: {SUMMARY}"
    try:
        table = json_of(folder / SUMMARY)
    except (OSError, ValueError) as error:
        raise InputError(f"{whose}: is damaged: {error}") from error
    if not isinstance(table, dict):
        raise InputError(f"{whose}: is damaged: it must hold one JSON object")
    if KEY not in table:
        raise InputError(
            f"{whose}: does not say which files belong to it (an older ehamj wrote it); {_run_again(folder)}"
        )
    return Told(folder, table, Belongs.read(table.pop(KEY), f"{whose}: {KEY}"))


def check_own(found: Told) -> None:
    """Refuse a result that lacks a file, or has one that its run did not write.

    Raises:
        InputError: which names the file.
    """
    belongs, whose = found.belongs, f"result {str(found.folder)!r}"
    for name in belongs.files:
        if name not in CARRYING:
            raise InputError(
                f"{whose}: {SUMMARY}: {KEY}.files names {name[:60]!r}, and a run writes {', '.join(CARRYING)}; "
                f"{_run_again(found.folder)}"
            )
    carried = {name: _carried(found.folder / name) for name in CARRYING if (found.folder / name).is_file()}
    carried[SUMMARY] = belongs.run
    for name, command in SHOWING.items():
        if (found.folder / name).is_file() and (run := _carried(found.folder / name)) not in (belongs.run, None):
            raise InputError(
                f"{whose}: {name} shows another run ({run}, the others are of {belongs.run}); take it away, and "
                f"`ehamj {command} {found.folder}` makes one of this run"
            )
    missing = [name for name in belongs.files if not (found.folder / name).is_file()]
    if missing:
        raise InputError(f"{whose}: {missing[0]} is missing, which its run wrote; {_run_again(found.folder)}")
    most, count = Counter(filter(None, carried.values())).most_common(1)[0]
    own = most if count > 1 else belongs.run
    for name, run in sorted(carried.items()):
        if run not in (own, None):
            raise InputError(
                f"{whose}: {name} is of another run ({run}, the others of {own}); put the one back that belongs there"
            )
        if name not in (*belongs.files, SUMMARY):
            raise InputError(f"{whose}: {name} is none of the files that its run wrote; take it away")


def check_unchanged(found: Told, names: Iterable[str]) -> None:
    """Refuse a result whose summary, or a file of ``names``, is not as its run wrote it.

    Raises:
        InputError: which names the file.
    """
    if _rest(found.summary) != found.belongs.rest:
        raise changed(found.folder, SUMMARY)
    for name in names:
        if digest_to_check(found.folder, name) != found.belongs.files[name]:
            raise changed(found.folder, name)


def check_result(folder: str | Path) -> Told:
    """A folder, checked to hold the files of one result as its run wrote them; what they say is not looked at.

    Raises:
        InputError: if it does not.
    """
    found = told(is_result(folder))
    check_own(found)
    check_unchanged(found, found.belongs.files)
    return found


def is_result(folder: str | Path) -> Path:
    """A folder, checked to hold the files of a result, of whatever run; raises InputError otherwise."""
    folder = Path(folder)
    if not folder.exists():
        raise InputError(f"result {str(folder)!r}: there is no such folder")
    missing = [name for name in RESULT_FILES if not (folder / name).is_file()]
    if missing:
        raise InputError(f"result {str(folder)!r}: is no result folder, {missing[0]} is missing")
    return folder


def check_variant(found: Told, name: str) -> None:
    """Refuse a variant's folder that holds another run than the one beside this result.

    Raises:
        InputError: if it does.
    """
    own, whose = found.belongs.variants.get(name), f"result {str(found.folder)!r}: variant {name!r}"
    if own is None:
        raise InputError(f"{whose}: did not run beside it; take its folder away, or show it by --compare")
    if (run := told(is_result(found.folder / name)).belongs.run) != own:
        raise InputError(
            f"{whose}: holds another run ({run}) than the one beside it ({own}); put that back, or show the other by "
            "--compare"
        )


def changed(folder: Path, name: str) -> InputError:
    """What to say of a file that is not as its run wrote it."""
    again = "runs what it says now" if name == "scenario.toml" else "makes the result anew"
    return InputError(
        f"result {str(folder)!r}: {name} is not as its run wrote it, damaged or changed by hand; put it back, or "
        f"`ehamj run {folder / 'scenario.toml'}` {again}"
    )


def digest_of(path: Path) -> str:
    """Of a file, as ``sha256sum`` prints it."""
    found, piece = hashlib.sha256(), memoryview(bytearray(PIECE))
    with path.open("rb", buffering=0) as file:
        while count := file.readinto(piece):
            check()
            found.update(piece[:count])
    return found.hexdigest()


def digest_to_check(folder: Path, name: str) -> str:
    """`digest_of` a file of a stored result; raises InputError if it cannot be read."""
    try:
        return digest_of(folder / name)
    except OSError as error:
        raise InputError(f"result {str(folder)!r}: {name} cannot be read: {error.strerror}") from error


def _run_again(folder: Path) -> str:
    return f"`ehamj run {folder / 'scenario.toml'}` makes the result anew"


def _rest(summary: Mapping[str, Any]) -> str:
    """Digest of a summary, whatever its file looks like."""
    return hashlib.sha256(json.dumps(summary, sort_keys=True).encode()).hexdigest()


def _carried(path: Path) -> str | None:
    """The identity that a file carries; None of one that has none, or cannot be read."""
    try:
        if path.name in SHOWING:
            with path.open("rb") as file:
                first = _CARRIED.search(file.read(BEGINNING))
            return str(first[1], "ascii") if first else None
        if path.name != HISTORIES:
            said = _CARRIED.findall(path.read_bytes())
            return str(said[-1], "ascii") if said else None
        import h5py

        with h5py.File(path, "r") as file:
            return str(file.attrs[RUN])
    except (OSError, KeyError, RuntimeError, TypeError, ValueError):  # h5py raises one or the other, as the damage lies
        return None

"""A labelled result, and its files: ``result.nc``, ``summary.json``, ``scenario.toml``, ``model.xml``."""

import contextlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import xarray as xr

from ehamj import columns, growing
from ehamj.above import ABOVE
from ehamj.belonging import (
    HISTORIES,
    RUN,
    SUMMARY,
    changed,
    check_own,
    check_unchanged,
    digest_to_check,
    identity_of,
    is_result,
    marked,
    summary_text,
    told,
    unmarked,
)
from ehamj.control import LinearController, load_controller
from ehamj.control.converter import check_mounts
from ehamj.errors import InputError
from ehamj.growing import Kept
from ehamj.interruption import pool_of
from ehamj.judge.brief import brief
from ehamj.judge.summary import Summary
from ehamj.notebook import html_table
from ehamj.plain.hdf5 import LARGEST, check_hdf5
from ehamj.plain.text import text_of
from ehamj.plain.xml import check_xml
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.scenario.variants import labels
from ehamj.unfinished import HELD, beside, check_room, clear_leftovers, remove
from ehamj.variables import DIMENSIONS, FIXED, VARIABLES, Stored, check_histories, stored_of, variables_of

if TYPE_CHECKING:
    from ehamj.report.alone import Plots

CONTROLLER_FILE = "controller.json"


@dataclass(frozen=True, repr=False)
class Result:
    """What a simulation gave.

    ``dataset`` holds the time histories (`VARIABLES`), ``summary`` the numbers a person asks for first,
    ``model_xml`` the compiled model as MJCF, ``controller`` the law that ran (none of a Python
    function, which no file can hold).
    """

    scenario: Scenario
    dataset: xr.Dataset
    summary: Summary
    model_xml: str = field(repr=False, default="")
    controller: LinearController | None = field(repr=False, default=None)
    kept: Kept | None = field(repr=False, default=None)
    """The file that the channels of a long run are read from."""

    @property
    def complete(self) -> bool:
        """Whether the simulation reached its end."""
        return self.summary.complete

    def in_memory(self) -> Self:
        """The same with all channels in memory, which pages and recordings need; raises InputError where they do not
        fit."""
        return self if self.kept is None else replace(self, dataset=self.kept.load(), kept=None)

    def __repr__(self) -> str:
        state = "complete" if self.complete else "INCOMPLETE"
        return f"<ehamj.Result {self.scenario.name!r}: {self.summary.timing.simulated_s:g} s, {state}>"

    def __str__(self) -> str:
        """The result in ten lines."""
        return "\n".join(f"{name + ':':14}{text}" for name, text in brief(self.summary).items())

    def _repr_html_(self) -> str:
        """The same ten lines, as a notebook shows them."""
        return html_table(brief(self.summary).items())

    @property
    def plot(self) -> "Plots":
        """The report's figures, one by one: ``result.plot.attenuation()`` gives its axes, which a notebook shows."""
        found: Plots = ABOVE["plot"](self)
        return found

    def replay(self, *beside: "Result") -> Any:
        """The machine in 3-D, beside other results: in a notebook within it, elsewhere in the Rerun viewer.

        Raises:
            InputError: if there is neither, which says what makes one.
        """
        return ABOVE["replay"](self, beside)

    def save(self, folder: str | Path, overwrite: bool = False, variants: "Iterable[Result]" = ()) -> None:
        """Write the folder that ``ehamj run`` writes, with report and replay as the scenario's ``output`` asks.

        Args:
            folder: to be made; one that is there must be empty, or a result and ``overwrite`` given.
            overwrite: whether another result may be replaced.
            variants: results of variants that the scenario's ``compare`` names (``scenario.variant("passive")``), which
                are shown beside it and get folders of their own.

        Raises:
            InputError: if the folder cannot be written, or a variant is none of the scenario's.
        """
        ABOVE["save"](self, folder, overwrite, variants)

    @property
    def identity(self) -> str:
        """What its files carry, so that those of one run are known (`ehamj.belonging`)."""
        given = self.dataset.attrs.get(RUN)  # none where it was put together by hand
        return str(given) if given else identity_of(self.scenario.to_toml(), self.summary.versions, self.dataset)

    @property
    def _stored(self) -> xr.Dataset:
        """The histories that its file holds, as the scenario's ``output.channels`` says."""
        there = list(map(str, self.dataset.data_vars))
        wanted = stored_of(self.scenario.output.channels, there)
        left_out = [name for name in there if name not in wanted]
        return self.dataset.drop_vars(left_out) if left_out else self.dataset

    def write(self, folder: Path, variants: Mapping[str, str] = MappingProxyType({})) -> None:
        """Write the result's files into an existing folder, each renamed into place when it is whole.

        Args:
            folder: of the result.
            variants: identity of each result that is written beside it, by the folder's name.
        """
        texts = {"scenario.toml": self.scenario.to_toml(), "model.xml": self.model_xml}
        if self.controller is not None:
            texts[CONTROLLER_FILE] = json.dumps(self.controller.to_dict(), indent=1) + "\n"
        with written_whole(folder / HISTORIES) as path:
            stored = self._stored
            own = self.kept if self.kept is not None and self.kept.dataset is stored else None
            if own is not None and own.put(path):
                pass
            elif self.kept is not None:
                growing.copied(stored.assign_attrs({RUN: self.identity}), columns.ROWS, path, beside(folder / "rows"))
            else:
                check_room(path, stored.nbytes)
                # Uncompressed: noise-like histories shrink by a sixth only, at the price of seconds.
                stored.assign_attrs({RUN: self.identity}).to_netcdf(path, engine="h5netcdf")
        for name, text in texts.items():
            with written_whole(folder / name) as path:
                path.write_text(marked(name, text, self.identity), encoding="utf-8")
        with written_whole(folder / SUMMARY) as path:
            text = summary_text(self.summary.to_dict(), self.identity, folder, (HISTORIES, *texts), variants)
            path.write_text(text, encoding="utf-8")


def load_result(folder: str | Path) -> Result:
    """Read a result folder; channels of a long run are read when they are asked for (`ehamj.growing.Kept`).

    Raises:
        InputError: if the folder is no result, or its files are not those of one run as it wrote them, or not what
            this version writes.
    """
    found = told(is_result(folder))
    folder, whose = found.folder, f"result {str(found.folder)!r}"
    summary = Summary.read(found.summary, f"{whose}: {SUMMARY}")
    check_own(found)
    check_unchanged(found, [name for name in found.belongs.files if name != HISTORIES])
    with pool_of(1) as pool:
        digest = pool.submit(digest_to_check, folder, HISTORIES)
        scenario, law = _ran(folder, whose)
        try:
            model = unmarked("model.xml", _model_of(folder / "model.xml"), found.belongs.run)
            kept, dataset = _channels_of(folder / HISTORIES)
        except Exception as error:  # h5py and xarray raise what they like at damage
            raise InputError(f"{whose}: is damaged: {error}") from error
        try:
            check_histories(dataset, scenario, law, summary)
        except ValueError as error:
            raise InputError(f"{whose}: {HISTORIES}: {error}") from error
        if len(dataset.data_vars) < len(variables_of(scenario, law)):
            dataset = Stored(dict(dataset.data_vars), dataset.coords, dataset.attrs)
            kept = kept and kept._replace(dataset=dataset)
        if digest.result() != found.belongs.files[HISTORIES]:
            raise changed(folder, HISTORIES)
    return Result(scenario, dataset, summary, model, law, kept)


def side_by_side(results: Sequence["Result"], to: str, folders: Sequence[Path] = ()) -> dict[str, "Result"]:
    """Results by what tells each from the others, in memory.

    Args:
        results: at least one.
        to: what is done with them, for the message.
        folders: that they are from; by default they have numbers.

    Raises:
        InputError: if one is no result, or holds no row.
    """
    for one in results:
        if not isinstance(one, Result):
            raise InputError(f"{to}: {one!r} is no result; ehamj.load_result(FOLDER) reads one")
    places = folders or [Path(str(number)) for number in range(1, len(results) + 1)]
    names = labels([one.scenario for one in results], places)
    for name, one in zip(names, results, strict=True):
        if not one.dataset.time.size:
            raise InputError(f"result {name!r}: failed before its first row, so that there is nothing to {to}")
    return dict(zip(names, (one.in_memory() for one in results), strict=True))


def _ran(folder: Path, whose: str) -> tuple[Scenario, LinearController | None]:
    """What a result is of: its scenario, and the law that its file holds, if there is one."""
    scenario, path = load_scenario(folder / "scenario.toml"), folder / CONTROLLER_FILE
    if not path.is_file():
        return scenario, None
    law = load_controller(path)
    try:
        check_mounts(law.converter, scenario.plant.mounts)
    except InputError as error:
        raise InputError(f"{whose}: {CONTROLLER_FILE}: {error}") from error
    return scenario, law


def _channels_of(path: Path) -> tuple[Kept | None, xr.Dataset]:
    """Stored channels in memory, or, of a long run, as they are asked for, in a file that is kept open."""
    size = path.stat().st_size
    check_hdf5(path, max(LARGEST, 2 * size))  # what is not compressed unfolds to what is there
    kept = Kept.of(path)
    if size > growing.IN_MEMORY:
        return kept, kept.dataset
    with kept.dataset as stored:
        return None, stored.load()


def _model_of(path: Path) -> str:
    """The stored model, if there is one; raises ValueError where it would draw in other files."""
    if not path.is_file():
        return ""

    def alone(name: str, attributes: dict[str, str]) -> None:
        if name in ("include", "plugin") or "file" in attributes:
            raise ValueError(f"model.xml: <{name}> draws in another file")

    text = text_of(path)
    check_xml(text.encode(), alone)
    return text


@contextlib.contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path`` to write to; renamed to ``path`` at the end, removed on failure."""
    clear_leftovers(path.parent)
    temporary = beside(path)
    HELD.add(temporary)
    try:
        yield temporary
        temporary.replace(path)
    finally:
        remove(temporary)


def make_dataset(
    time: np.ndarray,
    values: dict[str, np.ndarray],
    attributes: dict[str, Any],
    labels: Mapping[str, Sequence[Any]],
) -> xr.Dataset:
    """Label arrays of shape (time, …) with dimensions, units and names; ``values`` are keyed as `VARIABLES`.

    ``labels`` names what lies along the `DIMENSIONS` that are not `FIXED`, of those that the result has.
    """
    data = {}
    for name, array in values.items():
        dimensions, units, long_name = VARIABLES[name]
        data[name] = (("time", *dimensions), array, {"units": units, "long_name": long_name})
    clock = xr.Coordinates({"time": ("time", time, {"units": "s", "long_name": "time"})})
    others = _labelled(tuple((name, tuple(along)) for name, along in {**labels, **FIXED}.items()))
    return xr.Dataset(data, clock.merge(others).coords, attributes)


@lru_cache(maxsize=16)
def _labelled(labels: tuple[tuple[str, tuple[Any, ...]], ...]) -> xr.Coordinates:
    """What lies along dimensions, by name. Many runs have the same, and an index takes as long as some judge a run."""
    named = {name: (name, list(along), {"long_name": DIMENSIONS[name]}) for name, along in labels}
    return xr.Dataset(coords=named).coords

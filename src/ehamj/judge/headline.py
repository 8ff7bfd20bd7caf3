"""The headline: what a norm says where floor and machine are worst, with margin, band and the estimate's scatter.

A direction is judged by the worst of the places of the machine: its centre of gravity, each foot and every point. One
that is better says nothing of what stands elsewhere on the machine.
"""

from collections.abc import Mapping, Sequence

from pydantic import Field

from ehamj.criteria.curves import Norm
from ehamj.criteria.verdict import Verdict
from ehamj.findings import Finding
from ehamj.judge.decisive import Decisive, open_in_words
from ehamj.judge.levels import Levels
from ehamj.judge.places import AtPlace
from ehamj.judge.scatter import scatter


class Direction(Finding):
    """What decides along some axes: of the floor, and of the machine at its worst place, the others beside it."""

    floor: Decisive
    worst: Decisive
    others: list[Decisive]
    """The other places of the machine, worst first."""
    bands: int
    """How many bands could decide about the machine."""
    undecided: tuple[str, ...] = Field(alias="undecided_bands_hz")
    """Those that are not known: the class is then one that is met at best."""
    floor_bands: int
    floor_undecided: tuple[str, ...] = Field(alias="floor_undecided_bands_hz")

    def classes(self, actuated: str) -> str:
        """The classes of floor and machine in words, and how many bands they leave open; ``actuated`` says how the
        machine is."""
        sides = ((self.floor, self.floor_bands, self.floor_undecided), (self.worst, self.bands, self.undecided))
        floor, machine = (one.class_in_words(missing) for one, _, missing in sides)
        of_floor, left = (open_in_words(bands, missing) for _, bands, missing in sides)
        if of_floor != left:  # each by itself
            floor, machine, left = _beside(floor, of_floor), _beside(machine, left), ""
        said = f"floor {floor}, machine {machine} ({actuated})"
        return f"{said}: {left}" if left else said

    def details(self) -> str:
        """Where floor and machine are worst, by how much, and how the machine's other places stand."""
        sides = (("machine", self.worst, self.others), ("floor", self.floor, ()))
        found = []
        for what, worst, others in sides:
            if worst.verdict.deciding_band is not None and not worst.at_rest:
                found.append(f"{what} worst at {worst.where}: {worst.reason()}")
                found += [", ".join(other.briefly() for other in others)] if others else []
        said = "; ".join(found)
        return f"{said[:1].upper()}{said[1:]}"

    def at_worst(self) -> str:
        """Where the machine is worst and by how much; empty of one that rests or is not judged."""
        worst = self.worst
        if worst.verdict.deciding_band is None or worst.at_rest:
            return ""
        return f"Machine worst at {worst.where}: {worst.reason()}"

    def machine(self) -> str:
        """The machine's class at its worst place with margin and band, as a table of several runs holds it."""
        met = self.worst.class_in_words(self.undecided)
        left = open_in_words(self.bands, self.undecided)
        met = f"{met}: {left}" if left else met
        if self.worst.verdict.deciding_band is None or self.worst.at_rest:
            return met
        return f"{met}; worst at {self.worst.where}, {self.worst.reason()}"


def _beside(met: str, left: str) -> str:
    return f"{met} ({left})" if left else met


def direction(places: Mapping[str, AtPlace], axes: Sequence[str], norm: Norm, levels: Levels) -> Direction:
    """What decides along some axes.

    Args:
        places: what the norm says of each, the floor among them.
        axes: of the direction.
        norm: that judged.
        levels: by which it did.
    """
    found = {place: _decisive(place, judged, axes, norm, levels) for place, judged in places.items()}
    floor = found.pop("floor")
    ranked = sorted(found.values(), key=lambda one: norm.rank(one.verdict))
    bands, missing = _left_open([places[place] for place in found], axes, ranked[0], norm)
    floor_bands, floor_missing = _left_open([places["floor"]], axes, floor, norm)
    return Direction(
        floor=floor,
        worst=ranked[0],
        others=ranked[1:],
        bands=bands,
        undecided=missing,
        floor_bands=floor_bands,
        floor_undecided=floor_missing,
    )


def _decisive(place: str, judged: AtPlace, axes: Sequence[str], norm: Norm, levels: Levels) -> Decisive:
    axis = min(axes, key=lambda axis: norm.rank(judged[axis]))
    verdict: Verdict = judged[axis]
    mount: int | None = None
    scatters: list[float | None] = [None, None]
    if verdict.quantity is not None and verdict.statistic is not None:  # a level in a band decided, and no peak
        mount = levels.loudest(place, (verdict.quantity, verdict.statistic), axis, verdict.deciding_band)
    if verdict.statistic == "rms":
        scatters = [scatter(levels, place, mount, axis, band) for band in (verdict.deciding_band, verdict.next_band)]
    return Decisive(
        place=place,
        mount=None if mount is None else levels.mounts[mount],
        axis=axis,
        verdict=verdict,
        scatter_db=scatters[0],
        next_scatter_db=scatters[1],
    )


def _left_open(
    places: Sequence[AtPlace], axes: Sequence[str], decisive: Decisive, norm: Norm
) -> tuple[int, tuple[str, ...]]:
    """How many bands could make the class of a direction coarser, and those of them that are not known."""
    met, nothing = decisive.verdict.met, decisive.verdict.deciding_band is None
    could = {axis: norm.could_decide(axis, met, nothing) for axis in axes}
    order = list(dict.fromkeys(name for axis in axes for name in could[axis]))  # in each from low to high
    missing = {name for place in places for axis in axes for name in place[axis].undecided if name in could[axis]}
    return len(order), tuple(name for name in order if name in missing)

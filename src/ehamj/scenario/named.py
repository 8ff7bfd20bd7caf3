"""Mounts that a scenario calls by name: whoever renames them learns at once where the old names still stand."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ehamj.errors import did_you_mean

if TYPE_CHECKING:
    from ehamj.scenario.model import Scenario


def named_mounts(scenario: "Scenario") -> Iterator[tuple[str, str]]:
    """Every mount that is called by its name, with the key that does."""
    for part, key in ((scenario.ground, "ground"), (scenario.control, "control")):
        yield from ((f"{key}.{inner}", mount) for inner, mount in part.named_mounts())
    for k, fault in enumerate(scenario.fault):
        yield from ((f"fault.{k}.{inner}", mount) for inner, mount in fault.named_mounts())
    for k, relative in enumerate(scenario.relative):
        for key, place in (("from", relative.origin), ("to", relative.to)):
            what, _, mount = place.partition(" ")
            if what in ("foot", "ground") and mount:
                yield f"relative.{k}.{key}", mount


def check_named(scenario: "Scenario", mounts: Sequence[str]) -> None:
    """Refuse names that no mount has, all at once.

    Raises:
        ValueError: naming them, the keys that they stand in, and the mounts that there are.
    """
    unknown: dict[str, list[str]] = {}
    for key, mount in named_mounts(scenario):
        if mount not in mounts:
            unknown.setdefault(mount, []).append(key)
    if unknown:
        said = "; ".join(
            f"{mount!r} in {', '.join(dict.fromkeys(keys))}; {did_you_mean(mount, mounts)}".rstrip("; ")
            for mount, keys in unknown.items()
        )
        between = " " if said.endswith("?") else "; "
        raise ValueError(f"no mount has this name: {said}{between}[[mount]] has {', '.join(mounts)}")

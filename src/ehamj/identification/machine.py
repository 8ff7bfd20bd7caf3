"""A machine that has other values of some of its keys."""

from ehamj.campaign.keys import own_value
from ehamj.designs.parameters import changes_of
from ehamj.identification.unknowns import Values
from ehamj.scenario.model import Scenario


def with_values(scenario: Scenario, values: Values) -> Scenario:
    """The scenario with these values of its keys, its law as it was; a list's key gives all its elements one value.

    Raises:
        InputError: if a value is not allowed.
    """
    if not values:
        return scenario
    lists = {key: own_value(scenario, key) for key in values}
    given = {key: [value] * len(own) if isinstance(own := lists[key], list) else value for key, value in values.items()}
    changes = changes_of(scenario, given)
    if any(key.startswith("machine.inertia.") for key in changes):  # others would follow the mass
        mass = {key: changes.pop(key) for key in ("machine.mass",) if key in changes}
        changes = {**mass, "machine.inertia": scenario.machine.inertia, **changes}
    return scenario.varied(changes)

"""Parameters by the scenario's keys: where they begin, and their bounds."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ehamj.campaign.keys import check_known, own_value, unit_at
from ehamj.designs.parameters import mount_of, value_of
from ehamj.errors import InputError
from ehamj.identification.file import ParameterSettings
from ehamj.identification.machine import with_values
from ehamj.identification.unknowns import Prior, Unknown, Values
from ehamj.scenario.model import Scenario

USUAL = (0.5, 2.0)
"""Bounds of a value for which none are stated, over the scenario's own."""
NARROWER = 4
"""Times that bounds are halved which the scenario does not allow."""
TOGETHER = "machine.inertia."
"""Keys whose bounds are not tried one by one: what a moment of inertia may be at most is the sum of the others, which
are looked for as well. A point that is no body is a bad step of the fit."""


def parameters_of(scenario: Scenario, stated: Mapping[str, ParameterSettings]) -> tuple[Unknown, ...]:
    """What is looked for; each key and both its bounds are tried on the scenario.

    Raises:
        InputError: if a key is none of the scenario's, holds no number, or its bounds or start are not allowed.
    """
    found = {key: _parameter(scenario, key, settings) for key, settings in stated.items()}
    start = {key: one.start for key, one in found.items()}
    for key, one in found.items():
        if key.startswith(TOGETHER) and one.low > 0.0:
            continue
        if refused := _refused(scenario, start, one):
            if stated[key].bounds is not None:
                raise InputError(f"parameters: {key}: bounds = [{one.low:g}, {one.high:g}]: {refused}")
            found[key] = _narrowed(scenario, start, one)
    return tuple(found.values())


def _refused(scenario: Scenario, start: Values, one: Unknown) -> str:
    """Why a value at one of its bounds is not allowed, the others at their start; empty if both are."""
    for value in (one.low, one.high):
        try:
            with_values(scenario, {**start, one.name: value})
        except InputError as error:
            return str(error)
    return ""


def _narrowed(scenario: Scenario, start: Values, one: Unknown) -> Unknown:
    """With bounds, which nobody stated, so near to its start that they are allowed."""
    for _ in range(NARROWER):
        one = replace(one, low=0.5 * (one.start + one.low), high=0.5 * (one.start + one.high))
        if not (refused := _refused(scenario, start, one)):
            return one
    raise InputError(f"parameters: {one.name}: no other value of it is allowed ({refused})")


def _parameter(scenario: Scenario, key: str, settings: ParameterSettings) -> Unknown:
    own, said = _own(scenario, key), f"parameters: {key}"
    if settings.bounds is not None:
        low, high = settings.bounds
        if not low <= own <= high:
            raise InputError(
                f"{said}: bounds = [{low:g}, {high:g}]: must hold the scenario's own value, {own:g}; where the fit "
                "begins is set in the scenario (set)"
            )
    elif own == 0.0:
        raise InputError(f"{said}: the scenario has 0, of which bounds do not follow; state bounds = [low, high]")
    else:
        low, high = sorted(share * own for share in USUAL)
    prior = None if settings.prior is None else Prior(settings.prior.mean, settings.prior.deviation)
    return Unknown(key, unit_at(scenario, key), own, low, high, prior)


def _own(scenario: Scenario, key: str) -> float:
    """The scenario's own value."""
    said = f"parameters: {key}"
    if mount_of(scenario, key)[0] is not None and ".actuator." in key:
        return value_of(scenario, key)
    own = own_value(scenario, key, "parameters")
    if isinstance(own, list) and own and len(set(own)) == 1:
        own = own[0]
    if own is None:
        try:
            return value_of(scenario, key)
        except InputError:
            check_known(scenario, key, "parameters")
            raise InputError(f"{said}: the scenario leaves it out; give it a value to begin with (set)") from None
    if isinstance(own, bool) or not isinstance(own, int | float) or not np.isfinite(own):
        raise InputError(f"{said}: holds {own!r}; only a finite number can be looked for")
    return float(own)

"""What a component of an isolator declares, and an option of its valve.

A component is a class of settings; `ehamj.isolator.actuator.Actuator` inherits them all, and everything else follows
from that list: the keys of the user's table, the fields in memory (`ehamj.memory`) and the compiled equations
(`ehamj.isolator.equations`).
"""

from collections import namedtuple
from collections.abc import Collection, Iterable
from typing import Any, ClassVar, NamedTuple

from ehamj.compiled import kernel
from ehamj.settings import Parameters

HUGE = 1e300
"""Stands for infinity in memory, which the engine's files do not have."""


class Component(Parameters):
    """Settings of one component, and what its kernels take of them.

    ``takes`` names settings and properties; if it is empty, the kernels take all settings that are the component's own.
    ``Values`` is the named tuple of these, of floats. Each of its fields is a field of the isolator's record in memory,
    under that name. Kernels are annotated with the component itself, which has the same names.
    """

    takes: ClassVar[Any] = ()
    Values: ClassVar[Any] = None

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        super().__pydantic_init_subclass__(**options)
        own = cls.own_settings()
        if own:
            cls.Values = namedtuple("Values", cls.takes or own, module=cls.__module__)  # type: ignore[misc]
            cls.Values.__qualname__ = f"{cls.__name__}.Values"  # the cache of compiled code finds it by name

    @classmethod
    def own_settings(cls) -> list[str]:
        """Names of the settings that are the component's own."""
        known = {name for base in cls.__bases__ for name in getattr(base, "model_fields", ())}
        return [name for name in cls.model_fields if name not in known]

    @classmethod
    def values_of(cls, isolator: Any) -> Any:
        """``Values`` of an isolator that has this component."""
        return cls.Values(*(min(float(getattr(isolator, name)), HUGE) for name in cls.Values._fields))


class At(NamedTuple):
    """Where the valve stands: position x [mA] and rate ẋ [mA/s] of the spool, and what its options ask for."""

    position: float
    rate: float
    stroke: float
    """Position at which the edges are fully open, x_max [mA]."""
    held: float
    """Where the metering edges stood at the end of the last step [mA]."""
    time: float
    """Since the start [s]."""


STAGES = {
    "target": "position that the spool is driven to [mA], from the command's",
    "error": "what drives the spool [mA], from the distance to its target",
    "motion": "rate [mA/s] and acceleration [mA/s²] of the spool, a pair",
    "metering": "position of the metering edges [mA], from the spool's; is kept until the next step",
    "opening": "opening of the edges [mA], from their position",
    "flow": "opening [mA], no further than the full stroke, of the linear valve that would have this valve's flow",
    "settled": "position [mA] and rate [mA/s] of the spool at the end of a step, a pair",
}
"""Stages of a valve's signal path at which an option can have a kernel: what goes in and what comes out."""


class Option(Component):
    """Something that a valve may have and by default has not.

    ``path`` holds its kernels by stage (`STAGES`): (value, at: `At`, own: Values) → value. An option with states has
    one kernel, (value, at, own, state: State) → (value, rates), with rates a plain tuple; its states exist in a model,
    and the kernel is called, only for the isolators that have it ``on``.

    It may jump (dry friction does with ``at.rate``): runs take it as it is, the linear model refuses it by name where
    it has no derivative (`ehamj.linear.smooth`).
    """

    path: ClassVar[dict[str, Any]] = {}
    State: ClassVar[Any] = None
    scales: ClassVar[tuple[float, ...]] = ()
    """A small motion of each state, as a step for differences."""
    arithmetic: ClassVar[bool] = True
    """Whether its kernels are arithmetic alone, which the compiler does for many isolators at once; others (a lookup in
    a table) go one by one, and valves that have them."""

    def on(self) -> bool:
        """Whether the isolator has these states."""
        return False


@kernel
def _begin(value, at, isolator, states):  # type: ignore[no-untyped-def]
    return value, ()


def in_turn(stage: str, components: Iterable[type[Component]], absent: Collection[type[Component]] = ()) -> Any:
    """The kernels of all components at a stage as one, in their order: (value, at, isolator, states) → (value, rates).

    ``isolator`` and ``states`` are the tuples of `ehamj.isolator.equations`; rates are those of the states of the
    options that take part, one after the other. ``absent`` ones are left out, for isolators that have none of them.
    """
    composed = _begin
    number = 0
    for place, component in enumerate(components):
        if not issubclass(component, Option):
            continue
        if stage in component.path and component not in absent:
            follows = _then if component.State is None else _then_with_states
            composed = follows(composed, component.path[stage], place, number, len(component.scales))
        number += component.State is not None
    return composed


def _then(before: Any, own: Any, place: int, number: int, size: int) -> Any:
    @kernel
    def both(value, at, isolator, states):  # type: ignore[no-untyped-def]
        value, rates = before(value, at, isolator, states)
        return own(value, at, isolator[place]), rates

    return both


def _then_with_states(before: Any, own: Any, place: int, number: int, size: int) -> Any:
    still = (0.0,) * size

    @kernel
    def both(value, at, isolator, states):  # type: ignore[no-untyped-def]
        value, rates = before(value, at, isolator, states)
        own_rates = still
        if isolator.places[number] > 0.0:
            value, own_rates = own(value, at, isolator[place], states[number])
        return value, rates + own_rates

    return both

"""The two ways things go wrong for a user, and what he should have been told."""


class InputError(ValueError):
    """Bad input: the message names the key, the value and what is allowed. Nothing was computed or written."""


class SimulationFailed(RuntimeError):
    """The simulation itself failed: the message says what, where and when. What was computed until then is kept."""


class NotShown(RuntimeError):
    """A run is kept, and something that shows or judges it is not: the message says what, why, and what makes it."""


class DerivedAnew(UserWarning):
    """A law was derived for a changed machine: it knows what it could not know of a machine within tolerances."""


class PutElsewhere(UserWarning):
    """A result is not where it was to be: another run took the place while this one ran."""


class Recompiled(UserWarning):
    """Compiled code that was kept is damaged: it is compiled anew, which takes a while."""

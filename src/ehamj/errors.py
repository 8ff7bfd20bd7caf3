"""The two ways things go wrong for a user."""


class InputError(ValueError):
    """Bad input: the message names the key, the value and what is allowed. Nothing was computed or written."""


class SimulationFailed(RuntimeError):
    """The simulation itself failed: the message says what, where and when. What was computed until then is kept."""

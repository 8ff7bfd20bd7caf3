"""The kinds of test there are: one more is a file beside this one, and an entry here."""

from ehamj.identification.tests.hammer import HammerTest
from ehamj.identification.tests.modes import ModesTest
from ehamj.identification.tests.record import RecordTest
from ehamj.identification.tests.responses import ResponsesTest
from ehamj.identification.tests.static import StaticTest
from ehamj.identification.tests.test import TestSettings

TESTS: tuple[type[TestSettings], ...] = (
    RecordTest,
    ResponsesTest,
    HammerTest,
    StaticTest,
    ModesTest,
)
"""Every kind; a table [[test]] holds one of them."""

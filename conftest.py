"""The tests of the whole project are one run of pytest: see scripts/test.sh."""

import logging
import os
from typing import Any, Iterator, List

import pytest
from hypothesis import HealthCheck, settings
from run_seed import draws

# No test is about time by the clock of a busy computer. Each run draws the same, unless
# `scripts/test.sh random` asks for more: a test that fails is the fault of a change.
settings.register_profile(
    "any_speed",
    deadline=None,
    max_examples=draws(25),
    suppress_health_check=[HealthCheck.too_slow],
    derandomize="GPR20_SEED" not in os.environ,
    database=None,
)
settings.load_profile("any_speed")
# For another Python: what a test draws is examined under Debian's.
settings.register_profile("few_examples", settings.get_profile("any_speed"), max_examples=20)

pytest_plugins = ["pytest_gpr20"]


@pytest.fixture(scope="session")
def application() -> Iterator[Any]:
    """The only application of Qt, for all tests of a process, on a screen that nobody sees.

    A second one, or a widget that outlives the first, corrupts memory.
    """
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PyQt5.QtWidgets import QApplication

    yield QApplication.instance() or QApplication(["test"])


@pytest.fixture
def fault_log() -> Iterator[List[str]]:
    """What is logged of faults in threads; nothing of what a rospy of an earlier test logs."""
    texts: List[str] = []
    handler = logging.Handler()
    handler.addFilter(lambda record: hasattr(record, "said") and bool(record.said.fault))
    handler.emit = lambda record: texts.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("rosout")
    logger.addHandler(handler)
    yield texts
    logger.removeHandler(handler)

"""The tests of the whole project are one run of pytest: see scripts/test.sh."""

from hypothesis import settings

# For another Python: what a test draws is examined under Debian's.
settings.register_profile("few_examples", max_examples=20)

# The others import the first.
pytest_plugins = [
    "pytest_gpr20.last_line",
    "pytest_gpr20.workspace",
    "pytest_gpr20.rostest_items",
    "pytest_gpr20.real_time",
    "pytest_gpr20.time_limit",
    "pytest_gpr20.order",
]

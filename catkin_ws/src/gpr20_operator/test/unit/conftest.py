import sys
from pathlib import Path

# The example surveys of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))

from operator_kit import clock, events, node, now, services, storage  # noqa: F401
from translation_kit import shown_is_translated  # noqa: F401

import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[3]
# The example candidates of gpr20_survey's tests.
sys.path.append(str(SOURCES / "gpr20_survey" / "test" / "unit"))

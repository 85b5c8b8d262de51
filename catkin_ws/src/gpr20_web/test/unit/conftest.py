import sys
from pathlib import Path

from translation_kit import shown_is_translated  # noqa: F401

# The examples of the operator and of the surveys.
for package in ("gpr20_operator", "gpr20_survey"):
    sys.path.append(str(Path(__file__).resolve().parents[3] / package / "test" / "unit"))

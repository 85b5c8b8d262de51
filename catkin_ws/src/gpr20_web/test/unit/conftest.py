import sys
from pathlib import Path

# The examples of the window and of the surveys.
for package in ("gpr20_user_interface", "gpr20_survey"):
    sys.path.append(str(Path(__file__).resolve().parents[3] / package / "test" / "unit"))

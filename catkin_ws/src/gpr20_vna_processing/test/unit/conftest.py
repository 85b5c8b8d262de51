"""Makes the example traces of gpr20_survey's tests available to these."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))

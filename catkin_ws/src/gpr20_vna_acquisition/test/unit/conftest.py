"""Makes the modules of docs/extend/analyzer.md importable, as those of an installed package are."""

import sys
import tempfile
from pathlib import Path

from tutorial_code import code_blocks

PAGE = Path(__file__).parents[5] / "docs/extend/analyzer.md"
FOLDER = tempfile.TemporaryDirectory()
for _name, _code in code_blocks(PAGE, "python").items():
    Path(FOLDER.name, _name).write_text(_code)
sys.path.insert(0, FOLDER.name)

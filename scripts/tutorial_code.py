"""The code of a tutorial, taken from its page, so that the tests run what the page shows."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Dict


def code_blocks(page: Path, language: str) -> Dict[str, str]:
    """Return the code blocks of a language that follow a line `<!-- file: NAME -->`, by NAME."""
    block = re.compile(rf"^<!-- file: (\S+) -->\n```{re.escape(language)}\n(.*?)^```$", re.M | re.S)
    return dict(block.findall(page.read_text(encoding="utf-8")))

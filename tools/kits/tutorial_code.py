"""The code of a tutorial, taken from its page, so that tests run what people read."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Dict

_BLOCK = re.compile(
    r"^<!-- file: (?P<name>\S+) -->\n+```(?P<language>\w*)\n(?P<code>.*?)^```$", re.M | re.S
)


def code_blocks(page: Path, language: str) -> Dict[str, str]:
    """Return the code blocks of a Markdown page that are whole files.

    Args:
        page: The page. The comment `<!-- file: NAME -->` stands in the line before such a block.
        language: Language of the blocks, such as `python` or `yaml`.

    Returns:
        The content of each file, by its name.
    """
    return {
        match["name"]: match["code"]
        for match in _BLOCK.finditer(page.read_text("utf-8"))
        if match["language"] == language
    }

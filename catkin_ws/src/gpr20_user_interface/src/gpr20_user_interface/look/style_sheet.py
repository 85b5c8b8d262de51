"""The one style sheet of the window: style.qss with the colours and sizes of a look."""

from __future__ import annotations

import re
from pathlib import Path

from gpr20_user_interface.look.look import LEVEL_COLOURS, Look, Mark, TextColours

TEMPLATE = Path(__file__).with_name("style.qss")


def style_sheet(look: Look) -> str:
    """Return the style sheet of a theme at a scale."""
    rules = [TEMPLATE.read_text(encoding="utf-8")]
    for level, colours in LEVEL_COLOURS.items():
        job = f'[job="{level.value}"]'
        rules.append(f"QFrame#band{job}, QLabel{job} {{ @{colours.name} }}")

    def pair(found: re.Match[str]) -> str:
        ink, ground = look.text(TextColours[found[1]])
        return f"color: {ink}; background: {ground};"

    text = re.sub(r"@([A-Z_]+)", pair, "\n".join(rules))
    text = re.sub(r"\$([A-Z_]+)", lambda found: look.colour(Mark[found[1]]), text)
    return re.sub(r"\b([0-9]+)px", lambda found: f"{look.px(int(found[1]))}px", text)

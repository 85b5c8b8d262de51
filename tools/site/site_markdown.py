"""Markdown as GitHub reads it, changed to what MkDocs reads; and links to where the pages are."""

from __future__ import annotations

import posixpath
import re
from typing import Callable, Iterator, List, Tuple

FENCE = re.compile(r"\s*(```|~~~)")
HEADING = re.compile(r"#{1,6} ")
MARKER = re.compile(r"([-*+]|\d+[.)])( +)(?=\S)")
INLINE_LINK = re.compile(r"(\]\()([^)\s]+)(\))")
REFERENCE_LINK = re.compile(r"^(\[[^\]]+\]: +)(\S+)()$", re.MULTILINE)
# MkDocs wants four columns for each level of a list, GitHub the width of the marker.
LEVEL_COLUMNS = 4


def heading_anchor(text: str, separator: str = "-") -> str:
    """Return the anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", separator)


def changelog_markdown(text: str) -> str:
    """Return a changelog as Markdown.

    Args:
        text: reStructuredText as REP 132 of ROS wants it: a title, a section for each version, and
            lists, with code in double backquotes and words in bold.
    """
    text = re.sub(r"^\^+\n(.+)\n\^+$", r"# \1", text, flags=re.MULTILINE)
    text = re.sub(r"^(.+)\n-{4,}$", r"## \1", text, flags=re.MULTILINE)
    return text.replace("``", "`")


def fenced(text: str) -> Iterator[Tuple[str, bool]]:
    """Yield each line of a text, and whether it is part of a code block."""
    inside = False
    for line in text.splitlines():
        edge = bool(FENCE.match(line))
        yield line, inside or edge
        inside ^= edge


def indent_lists(text: str) -> str:
    """Return the text with lists as MkDocs reads them.

    What belongs to an item is indented by four columns, and a list has a blank line before it.
    """
    written: List[str] = []
    # The column at which the text of each open item begins.
    items: List[int] = []
    for line, code in fenced(text):
        body = line.lstrip(" ")
        column = len(line) - len(body)
        if not body:
            written.append("")
            continue
        marker = None if code else MARKER.match(body)
        begins = not written or not written[-1] or bool(marker)
        # A line that continues a paragraph may be indented less than its item.
        heading = not code and HEADING.match(body)
        if FENCE.match(body) or heading or (begins and not code):
            while items and column < items[-1]:
                items.pop()
        if heading or (marker and _is_paragraph(written[-1:])):
            written.append("")
        kept = max(column - items[-1], 0) if items else column
        written.append(" " * (LEVEL_COLUMNS * len(items) + kept) + body)
        if marker:
            items.append(column + marker.end())
    return "\n".join(written) + "\n"


def _is_paragraph(before: List[str]) -> bool:
    """Return whether the line before, if any, is text outside lists."""
    return bool(before) and bool(re.match(r"\S", before[0])) and not MARKER.match(before[0])


def rewrite_links(text: str, change: Callable[[str], str]) -> str:
    """Return the text with every relative link changed.

    Args:
        text: Markdown. Code blocks stay as they are.
        change: Returns the new target of a link.
    """

    def changed(match: re.Match[str]) -> str:
        target = match[2]
        if "://" in target or target.startswith(("#", "mailto:")):
            return match[0]
        return match[1] + change(target) + match[3]

    pieces: List[str] = []
    for line, code in fenced(text):
        if not code:
            line = INLINE_LINK.sub(changed, line)
            line = REFERENCE_LINK.sub(changed, line)
        pieces.append(line)
    return "\n".join(pieces) + "\n"


def relative_link(source: str, target: str, anchor: str) -> str:
    """Return the link from one page to another.

    Args:
        source: Path of the page that has the link, from the root of the site.
        target: Path of the page to which it leads.
        anchor: What follows the hash; may be empty.
    """
    path = posixpath.relpath(target, posixpath.dirname(source) or ".")
    return f"{path}#{anchor}" if anchor else path

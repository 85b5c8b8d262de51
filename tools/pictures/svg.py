"""The few shapes of SVG that the pictures of the documentation need."""

from __future__ import annotations

from html import escape
from typing import List, Tuple

Point = Tuple[float, float]

STYLE = """
text { font-family: Helvetica, Arial, sans-serif; font-size: 13px; fill: #1b2a30; }
.mono { font-family: Menlo, Consolas, monospace; font-size: 11.5px; }
.title { font-weight: bold; font-size: 14px; }
.small { font-size: 11.5px; fill: #4a5a60; }
.band { fill: #eef4f5; stroke: #9fb4ba; }
.box { fill: #ffffff; stroke: #00796b; stroke-width: 1.5; }
.other { fill: #ffffff; stroke: #8a8a8a; stroke-width: 1.5; }
.arrow { stroke: #37474f; stroke-width: 1.6; fill: none; marker-end: url(#head); }
.thin { stroke: #b0bec5; stroke-width: 1.1; fill: none; marker-end: url(#pale); }
"""
HEADS = "".join(
    f'<marker id="{name}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
    f'orient="auto-start-reverse"><path d="M0 0L10 5L0 10z" fill="{colour}"/></marker>'
    for name, colour in (("head", "#37474f"), ("pale", "#b0bec5"))
)


class Picture:
    """A picture to which shapes are added; `text` is its SVG.

    Args:
        width: In pixels.
        height: In pixels.
        title: What it shows, for readers who cannot see it.
    """

    def __init__(self, width: float, height: float, title: str) -> None:
        self._parts: List[str] = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
            f'width="{width:g}" height="{height:g}" role="img">',
            f"<title>{escape(title)}</title>",
            f"<style>{STYLE}</style><defs>{HEADS}</defs>",
            f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
        ]

    def box(self, corner: Point, size: Point, style: str) -> None:
        """Add a rectangle with round corners."""
        (x, y), (width, height) = corner, size
        self._parts.append(
            f'<rect class="{style}" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" '
            'rx="6"/>'
        )

    def words(self, place: Point, text: str, style: str = "", anchor: str = "start") -> None:
        """Add one line of text; the place is on its baseline."""
        x, y = place
        self._parts.append(
            f'<text class="{style}" x="{x:g}" y="{y:g}" text-anchor="{anchor}">'
            f"{escape(text)}</text>"
        )

    def arrow(self, points: List[Point], style: str = "arrow") -> None:
        """Add straight lines through points, with a head at the last."""
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        self._parts.append(f'<path class="{style}" d="{path}"/>')

    def curve(self, start: Point, bend: Point, end: Point, style: str = "arrow") -> None:
        """Add a curve with a head at its end, drawn towards a third point."""
        (a, b), (c, d), (e, f) = start, bend, end
        path = f"M{a:.1f} {b:.1f}Q{c:.1f} {d:.1f} {e:.1f} {f:.1f}"
        self._parts.append(f'<path class="{style}" d="{path}"/>')

    @property
    def text(self) -> str:
        """The picture as a file."""
        return "\n".join([*self._parts, "</svg>"]) + "\n"

"""The part of the style sheet for tiles, fields and keys."""

from __future__ import annotations

from typing import Dict

from gpr20_user_interface.views.look import BORDER_PX, TEXT_PX, TITLE_PX, Look
from gpr20_user_interface.views.palette import Mark, TextColours

# Sizes of the letters of a field, from the largest [px of the design].
FITS: Dict[str, int] = {"large": 26, "middle": 22, "small": TEXT_PX}
CHOSEN_BORDER_PX = 4
START_PX = 28


def plan_style(look: Look) -> str:
    """Return the rules of a theme at a scale."""
    return _tiles(look) + _boxes(look) + _fits(look)


def _both(look: Look, colours: TextColours) -> str:
    pair = look.text(colours)
    return f"color: {pair.ink}; background: {pair.ground};"


def _tiles(look: Look) -> str:
    px = look.px
    # Properties, not :pressed and :disabled, which Qt ignores before a descendant.
    states = {
        "QPushButton#tile": TextColours.ARROW,
        "QPushButton#start": TextColours.START,
        'QPushButton#tile[level="doubtful"]': TextColours.DOUBTFUL,
        'QPushButton#tile[level="wrong"]': TextColours.WRONG,
        'QPushButton#tile[level="locked"]': TextColours.LOCKED,
        'QPushButton#start[level="locked"]': TextColours.DISABLED,
        'QPushButton#tile[level="pressed"]': TextColours.PRESSED,
        'QPushButton#start[level="pressed"]': TextColours.PRESSED,
    }
    rules = "".join(
        f"{state} {{ {_both(look, colours)} }}\n{state} QLabel {{ {_both(look, colours)} }}\n"
        for state, colours in states.items()
    )
    return f"""
{rules}
QPushButton#tile, QPushButton#start {{ padding: 0; font-weight: normal; }}
QPushButton#tile QLabel#tile_title, QPushButton#start QLabel#tile_title {{ font-weight: bold;
    font-size: {px(TITLE_PX)}px; }}
QPushButton#start QLabel#tile_title {{ font-size: {px(START_PX)}px; }}
QPushButton#start[level="locked"] QLabel#tile_title {{ font-size: {px(TITLE_PX)}px; }}
"""


def _boxes(look: Look) -> str:
    px, border = look.px, look.colour(Mark.BORDER)
    chosen, wrong = look.text(TextColours.CHOSEN), look.text(TextColours.WRONG)
    return f"""
QFrame#box {{ border: {px(BORDER_PX)}px solid {border}; border-radius: {px(4)}px; }}
QFrame#box[chosen="true"] {{ border: {px(CHOSEN_BORDER_PX)}px solid {chosen.ground}; }}
QFrame#box[wrong="true"], QFrame#box[wrong="true"] * {{ {_both(look, TextColours.WRONG)} }}
QFrame#box[wrong="true"][chosen="true"] {{ border-color: {wrong.ink}; }}
QFrame#box QLineEdit {{ border: none; min-height: 0; padding: 0; font-weight: bold; }}
QFrame#box QPlainTextEdit {{ border: none; min-height: 0; }}
QFrame#box[wrong="true"] QLineEdit {{ border: none; }}
QPushButton#key {{ padding: 0; min-width: {px(40)}px; }}
QPushButton#key[long="true"] {{ font-size: {px(TEXT_PX)}px; }}
QPlainTextEdit#entry {{ min-height: {px(40)}px; }}
QPushButton#preset {{ {_both(look, TextColours.ARROW)} padding: 0 {px(2)}px; }}
QPushButton#preset:checked {{ {_both(look, TextColours.CHOSEN)} }}
QPushButton#preset:pressed {{ {_both(look, TextColours.PRESSED)} }}
"""


def _fits(look: Look) -> str:
    return "".join(
        f'QLineEdit[fit="{name}"] {{ font-size: {look.px(size_px)}px; }}\n'
        for name, size_px in FITS.items()
    )

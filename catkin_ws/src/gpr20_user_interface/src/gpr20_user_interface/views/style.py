"""Colours, sizes and the one style sheet of the window."""

from __future__ import annotations

import enum
from typing import Callable, Dict, NamedTuple

from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_user_interface.mid.map_coverage import StopState

# What a gloved finger hits.
TOUCH_PX = 44
COMMAND_PX = 56
STOP_WIDTH_PX = 140
TEXT_PX = 15
SMALL_TEXT_PX = 13
BORDER_PX = 2

# Colours that are lines and marks, not text.
BORDER = "#555555"
PAPER = "#ffffff"
# Those of map and radar differ in brightness too, for people who see no colours.
STOP_COLOURS: Dict[StopState, str] = {
    StopState.MISSING: "#d9d9d9",
    StopState.PARTLY: "#8ab8e6",
    StopState.DONE: "#1f4e8c",
    StopState.FAILED: "#d94801",
}
CURRENT = "#ffd400"
CARRIAGE = "#000000"
SELECTED = "#c000c0"
CURVE = "#1f4e8c"
SURFACE_LINE = "#a80000"


class ColourPair(NamedTuple):
    """Text and its background."""

    ink: str
    ground: str


class TextColours(enum.Enum):
    """Every pair of colours in which the window writes."""

    PLAIN = ColourPair("#111111", PAPER)
    QUIET = ColourPair("#444444", PAPER)
    WRONG = ColourPair("#8f0000", "#ffe3e3")
    PROBLEM = ColourPair("#a80000", PAPER)
    LOCKED = ColourPair("#333333", "#e8e8e8")
    DISABLED = ColourPair("#555555", "#dddddd")
    BUTTON = ColourPair("#ffffff", "#1f4e8c")
    ARROW = ColourPair("#111111", "#d5e3f5")
    CHOSEN = ColourPair("#ffffff", "#0b3160")
    START = ColourPair("#ffffff", "#1b6b2f")
    STOP = ColourPair("#ffffff", "#a80000")
    PRESSED = ColourPair("#111111", "#ffd400")
    REPLAY = ColourPair("#ffffff", "#0a5fb4")
    SIMULATED = ColourPair("#111111", "#ffd400")
    ALARM = ColourPair("#ffffff", "#8f0000")
    GOOD = ColourPair("#ffffff", "#1b6b2f")
    DOUBTFUL = ColourPair("#111111", "#ffd400")
    BAD = ColourPair("#ffffff", "#a80000")
    PROGRESS_EMPTY = ColourPair("#111111", "#f2f2f2")
    PROGRESS_FULL = ColourPair("#111111", "#9cc9f5")


def css(colours: TextColours) -> str:
    """Return the two colours as declarations of a style sheet."""
    return f"color: {colours.value.ink}; background: {colours.value.ground};"


STYLE_SHEET = f"""
QWidget {{ {css(TextColours.PLAIN)} font-size: {TEXT_PX}px; }}
QLabel#title {{ font-size: 18px; font-weight: bold; }}
QLabel#preview {{ font-weight: bold; }}
QLabel#figure {{ font-size: 18px; font-weight: bold; }}
QLabel#quiet {{ {css(TextColours.QUIET)} font-size: {SMALL_TEXT_PX}px; }}
QLabel#problem {{ {css(TextColours.PROBLEM)} font-weight: bold; }}
QWidget#replay, QWidget#replay QLabel {{ {css(TextColours.REPLAY)} }}
QLabel#simulated, QWidget#replay QLabel#simulated {{ {css(TextColours.SIMULATED)}
    font-weight: bold; padding: 4px; }}
QLabel#alarm {{ {css(TextColours.ALARM)} font-size: {SMALL_TEXT_PX}px; font-weight: bold;
    padding: 0 6px; }}
QLabel[level="good"] {{ {css(TextColours.GOOD)} padding: 0 3px; }}
QLabel[level="doubtful"] {{ {css(TextColours.DOUBTFUL)} padding: 0 3px; }}
QLabel[level="bad"] {{ {css(TextColours.BAD)} padding: 0 3px; }}
QLabel[level="wrong"] {{ {css(TextColours.WRONG)} }}

QTabWidget::pane {{ border: none; border-top: {BORDER_PX}px solid {BORDER}; }}
QTabBar::tab {{ {css(TextColours.ARROW)} min-height: {TOUCH_PX}px; padding: 0 14px;
    border: 1px solid {BORDER}; }}
QTabBar::tab:selected {{ {css(TextColours.CHOSEN)} }}

QPushButton {{ {css(TextColours.BUTTON)} min-height: {TOUCH_PX}px; min-width: {TOUCH_PX}px;
    border: {BORDER_PX}px solid {BORDER}; border-radius: 6px; font-weight: bold; padding: 0 6px; }}
QPushButton#start {{ {css(TextColours.START)} font-size: 18px; }}
QPushButton#stop {{ {css(TextColours.STOP)} font-size: 24px; min-width: {STOP_WIDTH_PX}px; }}
QPushButton#replay_pause {{ {css(TextColours.ARROW)} min-width: {STOP_WIDTH_PX - 20}px; }}
QPushButton#arrow {{ {css(TextColours.ARROW)} font-size: 18px; padding: 0; }}
QPushButton#key {{ {css(TextColours.ARROW)} font-size: 22px; }}
QPushButton:checked {{ {css(TextColours.CHOSEN)} }}
QPushButton:pressed, QPushButton#start:pressed, QPushButton#stop:pressed,
QPushButton#arrow:pressed, QPushButton#key:pressed {{ {css(TextColours.PRESSED)} }}
QPushButton:disabled, QPushButton#start:disabled, QPushButton#stop:disabled,
QPushButton#arrow:disabled {{ {css(TextColours.DISABLED)} }}

QLineEdit {{ min-height: {TOUCH_PX - 2 * BORDER_PX}px; border: {BORDER_PX}px solid {BORDER};
    border-radius: 4px; padding: 0 4px; }}
QLineEdit[wrong="true"] {{ {css(TextColours.WRONG)} border-color: {TextColours.WRONG.value.ink}; }}
QLineEdit:disabled {{ {css(TextColours.LOCKED)} }}
QPlainTextEdit, QTextEdit {{ border: none; min-height: {TOUCH_PX}px; }}
QPlainTextEdit#notes, QPlainTextEdit#entry {{ border: {BORDER_PX}px solid {BORDER};
    border-radius: 4px; }}
QPlainTextEdit#notes[wrong="true"] {{ {css(TextColours.WRONG)} }}
QTextEdit#details {{ {css(TextColours.QUIET)} font-size: {SMALL_TEXT_PX}px; }}
QListWidget {{ border: {BORDER_PX}px solid {BORDER}; }}
QListWidget::item {{ min-height: {TOUCH_PX}px; }}
QListWidget::item:selected {{ {css(TextColours.CHOSEN)} }}
QScrollBar:vertical {{ background: {TextColours.DISABLED.value.ground}; width: {TOUCH_PX}px; }}
QScrollBar::handle:vertical {{ background: {TextColours.BUTTON.value.ground};
    min-height: {TOUCH_PX}px; border: {BORDER_PX}px solid {BORDER}; border-radius: 6px; }}
QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical {{ height: 0; }}

QProgressBar {{ {css(TextColours.PROGRESS_EMPTY)} min-height: 32px;
    border: {BORDER_PX}px solid {BORDER}; border-radius: 4px; text-align: center;
    font-weight: bold; }}
QProgressBar::chunk {{ background: {TextColours.PROGRESS_FULL.value.ground}; }}
QSlider::groove:vertical {{ background: {BORDER}; width: 8px; border-radius: 4px; }}
QSlider::handle:vertical {{ background: {TextColours.BUTTON.value.ground}; height: {TOUCH_PX}px;
    margin: 0 -16px; border: {BORDER_PX}px solid {BORDER}; border-radius: 6px; }}
QTableWidget::item:selected {{ {css(TextColours.CHOSEN)} }}
QFrame#sheet {{ border: {BORDER_PX}px solid {BORDER}; }}
"""


def new_button(act: Callable[[], None], text: str = "") -> QPushButton:
    """Return a button that does something when it is clicked."""
    button = QPushButton(text)
    # Not the function itself, which would get whether the button is checked.
    button.clicked.connect(lambda: act())
    return button


def set_look(widget: QWidget, name: str, value: object) -> None:
    """Set a property that the style sheet asks for; it looks at them only when it is applied."""
    if widget.property(name) != value:
        widget.setProperty(name, value)
        widget.style().unpolish(widget)
        widget.style().polish(widget)

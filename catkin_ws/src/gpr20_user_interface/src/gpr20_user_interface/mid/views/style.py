"""Colours and sizes of the window, in one style sheet."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget

# What a gloved finger hits.
TOUCH_PX = 44
COMMAND_PX = 56

STYLE_SHEET = f"""
QWidget {{ background: #ffffff; color: #111111; font-size: 15px; }}
QLabel#title {{ font-size: 22px; font-weight: bold; }}
QLabel#banner {{ background: #ffd400; color: #111111; font-weight: bold; padding: 4px; }}
QLabel#alarm {{ background: #a80000; color: #ffffff; font-weight: bold; padding: 4px; }}
QPlainTextEdit#problems {{ color: #a80000; }}
QPlainTextEdit {{ border: none; }}
QLineEdit {{ min-height: {TOUCH_PX - 4}px; max-height: {TOUCH_PX - 4}px; border: 2px solid #555555;
    border-radius: 4px; padding: 0 4px; }}
QLineEdit[wrong="true"] {{ background: #ffe3e3; border-color: #a80000; }}
QLineEdit:disabled {{ background: #e8e8e8; color: #333333; }}
QProgressBar {{ min-height: 32px; border: 2px solid #555555; border-radius: 4px;
    text-align: center; font-weight: bold; background: #f2f2f2; }}
QProgressBar::chunk {{ background: #9cc9f5; }}
QPushButton {{ min-height: {COMMAND_PX - 4}px; border: 2px solid #333333; border-radius: 6px;
    font-size: 18px; font-weight: bold; color: #ffffff; background: #1f4e8c; padding: 0 12px; }}
QPushButton#start {{ background: #1b6b2f; }}
QPushButton#stop {{ background: #a80000; }}
QPushButton:disabled, QPushButton#start:disabled, QPushButton#stop:disabled {{
    background: #dddddd; color: #555555; border-color: #999999; }}
"""


def set_wrong(widget: QWidget, wrong: bool) -> None:
    """Let a widget look wrong, or right again."""
    if widget.property("wrong") != wrong:
        widget.setProperty("wrong", wrong)
        # A style sheet looks at properties only when it is applied.
        widget.style().unpolish(widget)
        widget.style().polish(widget)

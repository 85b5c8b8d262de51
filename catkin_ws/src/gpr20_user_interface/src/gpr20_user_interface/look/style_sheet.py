"""The one style sheet of the window."""

from __future__ import annotations

from typing import Dict

from gpr20_user_interface.look.look import (
    BORDER_PX,
    COMMAND_PX,
    LEVEL_COLOURS,
    TEXT_PX,
    TITLE_PX,
    TOUCH_PX,
    Look,
    Mark,
    TextColours,
)

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
        "QPushButton#start": TextColours.GOOD,
        'QPushButton#tile[level="doubtful"]': TextColours.DOUBTFUL,
        'QPushButton#tile[level="wrong"]': TextColours.WRONG,
        'QPushButton#tile[level="locked"]': TextColours.LOCKED,
        'QPushButton#start[level="second"]': TextColours.ARROW,
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
QPushButton#start[level="locked"] QLabel#tile_title,
QPushButton#start[level="second"] QLabel#tile_title {{ font-size: {px(TITLE_PX)}px; }}
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


STOP_WIDTH_PX = 140
PAUSE_WIDTH_PX = 110
SLIDER_PX = 8
# So that two lines have room below the title of the band.
BAND_TITLE_PX, BAND_TEXT_PX = 20, 16


def style_sheet(look: Look) -> str:
    """Return the style sheet of a theme at a scale."""
    own = _texts(look) + _buttons(look) + _fields(look) + _bars(look)
    return own + _job(look) + plan_style(look)


def _css(look: Look, colours: TextColours) -> str:
    pair = look.text(colours)
    return f"color: {pair.ink}; background: {pair.ground};"


def _texts(look: Look) -> str:
    def css(colours: TextColours) -> str:
        return _css(look, colours)

    px = look.px
    return f"""
QWidget {{ {css(TextColours.PLAIN)} font-size: {px(TEXT_PX)}px; }}
QLabel#title {{ font-size: {px(TITLE_PX)}px; font-weight: bold; }}
QLabel#preview {{ font-weight: bold; }}
QLabel#figure {{ font-size: {px(TITLE_PX)}px; font-weight: bold; }}
QLabel#ground_note, QLabel#shown_band, QScrollArea#ground_text QLabel {{
    font-size: {px(TEXT_PX - 2)}px; }}
QLabel#quiet {{ {css(TextColours.QUIET)} }}
QLabel#shown_band {{ {css(TextColours.PAST)} font-weight: bold; }}
QLabel#shown_band[replay="true"] {{ {css(TextColours.REPLAY)} }}
QWidget#lock_band, QLabel#locked {{ {css(TextColours.SIMULATED)} font-weight: bold; }}
QLabel#locked[flash="true"] {{ {css(TextColours.ALARM)} }}
QLabel#simulated {{ {css(TextColours.SIMULATED)}
    font-weight: bold; padding: {px(4)}px; }}
QLabel#alarm {{ {css(TextColours.ALARM)} font-weight: bold; padding: 0 {px(6)}px; }}
QLabel[level="good"] {{ {css(TextColours.GOOD)} padding: 0 {px(6)}px; }}
QLabel[level="doubtful"] {{ {css(TextColours.DOUBTFUL)} padding: 0 {px(6)}px; }}
QLabel[level="bad"] {{ {css(TextColours.BAD)} padding: 0 {px(6)}px; }}
QLabel[level="wrong"] {{ {css(TextColours.WRONG)} }}
QLabel[lamp="on"] {{ {css(TextColours.DOUBTFUL)} font-weight: bold; }}
QFrame#sheet {{ border: {px(BORDER_PX)}px solid {look.colour(Mark.BORDER)}; }}
"""


def _buttons(look: Look) -> str:
    def css(colours: TextColours) -> str:
        return _css(look, colours)

    px, border = look.px, look.colour(Mark.BORDER)
    frame = px(BORDER_PX)
    touch = px(TOUCH_PX) - 2 * frame
    return f"""
QPushButton {{ {css(TextColours.BUTTON)} min-height: {touch}px; min-width: {touch}px;
    border: {frame}px solid {border}; border-radius: {px(6)}px; font-weight: bold;
    padding: 0 {px(6)}px; }}
QPushButton#start {{ {css(TextColours.GOOD)} font-size: {px(TITLE_PX)}px;
    min-height: {px(COMMAND_PX) - 2 * frame}px; }}
QPushButton#stop {{ {css(TextColours.BAD)} font-size: {px(28)}px;
    min-width: {px(STOP_WIDTH_PX)}px; }}
QPushButton#key {{ {css(TextColours.ARROW)} font-size: {px(24)}px; }}
QPushButton#jog {{ padding: 0; }}
QPushButton#choice, QPushButton#field {{ {css(TextColours.ARROW)} }}
QPushButton#field {{ text-align: left; padding: 0 {px(8)}px; font-weight: normal; }}
QPushButton#choice:checked {{ {css(TextColours.CHOSEN)} }}
QPushButton#hold, QPushButton#jog {{ {css(TextColours.ARROW)} }}
QFrame#sheet QPushButton#hold {{ font-size: {px(TITLE_PX)}px; }}
QPushButton:checked {{ {css(TextColours.CHOSEN)} }}
QPushButton:pressed, QPushButton#start:pressed, QPushButton#stop:pressed,
QPushButton#key:pressed {{ {css(TextColours.PRESSED)} }}
QPushButton#hold:pressed, QPushButton#jog:pressed {{ {css(TextColours.ARROW)} }}
QPushButton:disabled, QPushButton#start:disabled, QPushButton#stop:disabled,
QPushButton#choice:disabled {{ {css(TextColours.DISABLED)}
    border-style: dashed; }}
QPushButton#ground_key {{ {css(TextColours.ARROW)} font-size: {px(TEXT_PX - 2)}px;
    padding: 0; min-width: {px(48) - 2 * frame}px; min-height: {px(48) - 2 * frame}px; }}
QPushButton#ground_key:checked {{ {css(TextColours.CHOSEN)} }}
QPushButton#ground_key:pressed {{ {css(TextColours.PRESSED)} }}
QPushButton#ground_key:disabled {{ {css(TextColours.DISABLED)} }}
QToolButton#rail {{ {css(TextColours.ARROW)} border: none; font-weight: bold;
    border-right: {frame}px solid {border}; border-bottom: 1px solid {border}; }}
QToolButton#rail:checked {{ {css(TextColours.CHOSEN)} }}
QToolButton#rail:pressed {{ {css(TextColours.PRESSED)} }}
"""


def _fields(look: Look) -> str:
    def css(colours: TextColours) -> str:
        return _css(look, colours)

    px, border = look.px, look.colour(Mark.BORDER)
    frame = px(BORDER_PX)
    line = f"border: {frame}px solid"
    return f"""
QLineEdit {{ min-height: {px(TOUCH_PX) - 2 * frame}px; {line} {border};
    border-radius: {px(4)}px; padding: 0 {px(4)}px; }}
QLineEdit[wrong="true"] {{ {css(TextColours.WRONG)}
    border-color: {look.text(TextColours.WRONG).ink}; }}
QLineEdit:disabled {{ {css(TextColours.LOCKED)} }}
QPlainTextEdit, QTextEdit {{ border: none; min-height: {px(TOUCH_PX)}px; }}
QPlainTextEdit#notes, QPlainTextEdit#entry {{ {line} {border}; border-radius: {px(4)}px; }}
QPlainTextEdit#notes[wrong="true"] {{ {css(TextColours.WRONG)} }}
QTextEdit#details {{ {css(TextColours.QUIET)} }}
QListWidget {{ {line} {border}; }}
QListWidget::item {{ min-height: {px(TOUCH_PX)}px; }}
QListWidget::item:selected {{ {css(TextColours.CHOSEN)} }}
QTableWidget::item:selected {{ {css(TextColours.CHOSEN)} }}
"""


def _bars(look: Look) -> str:
    px, border = look.px, look.colour(Mark.BORDER)
    touch, frame = px(TOUCH_PX), px(BORDER_PX)
    handle = look.text(TextColours.BUTTON).ground
    groove = look.text(TextColours.DISABLED).ground
    return f"""
QScrollBar:vertical {{ background: {groove}; width: {touch}px; }}
QScrollBar::handle:vertical {{ background: {handle}; min-height: {touch}px;
    border: {frame}px solid {border}; border-radius: {px(6)}px; }}
QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical {{ height: 0; }}
QProgressBar {{ {_css(look, TextColours.PROGRESS_EMPTY)} min-height: {px(36)}px;
    border: {frame}px solid {border}; border-radius: {px(4)}px; text-align: center;
    font-weight: bold; }}
QProgressBar::chunk {{ background: {look.text(TextColours.PROGRESS_FULL).ground}; }}
QSlider::groove:vertical {{ background: {border}; width: {px(SLIDER_PX)}px;
    border-radius: {px(4)}px; }}
QSlider::handle:vertical {{ background: {handle}; height: {touch}px;
    margin: 0 -{px((TOUCH_PX - SLIDER_PX) / 2)}px; border: {frame}px solid {border};
    border-radius: {px(6)}px; }}
"""


def _job(look: Look) -> str:
    px = look.px
    bands = "".join(
        f"""
QFrame#band[job="{level.value}"], QLabel[job="{level.value}"] {{
    {_css(look, colours)} }}"""
        for level, colours in LEVEL_COLOURS.items()
    )
    return f"""{bands}
QFrame#band QLabel {{ font-size: {px(BAND_TEXT_PX)}px; }}
QFrame#band QLabel#title {{ font-size: {px(BAND_TITLE_PX)}px; }}
QFrame#band QLabel#simulated {{ {_css(look, TextColours.SIMULATED)} padding: 0 {px(4)}px; }}
QFrame#band QLabel#what_to_do {{ font-weight: bold; padding: 0 {px(4)}px;
    border: {px(BORDER_PX)}px solid; border-radius: {px(4)}px; }}
QPushButton#part {{ {_css(look, TextColours.ARROW)} font-weight: normal; padding: 0 {px(2)}px; }}
QPushButton#part[level="doubtful"] {{ {_css(look, TextColours.DOUBTFUL)} font-weight: bold; }}
QPushButton#part[level="bad"] {{ {_css(look, TextColours.BAD)} font-weight: bold; }}
QPushButton#part:pressed {{ {_css(look, TextColours.PRESSED)} }}
QPushButton#pause {{ min-width: {px(PAUSE_WIDTH_PX)}px; font-size: {px(TITLE_PX)}px; }}
QLabel#job_title {{ font-size: {px(30)}px; font-weight: bold; }}
QLabel#percent {{ font-size: {px(64)}px; font-weight: bold; }}
QTextEdit#reason {{ font-size: {px(TITLE_PX)}px; }}
QFrame#tile {{ border: {px(BORDER_PX)}px solid {look.colour(Mark.BORDER)};
    border-radius: {px(6)}px; min-height: {px(TOUCH_PX)}px; }}
QLabel#tile_title {{ font-weight: bold; }}
QLabel#first_title {{ font-weight: bold; }}
QLabel#first {{ {_css(look, TextColours.DOUBTFUL)} font-size: {px(TITLE_PX)}px; font-weight: bold;
    padding: {px(6)}px; }}
QFrame#stop_warning, QFrame#stop_warning QLabel {{ {_css(look, TextColours.BAD)} }}
QFrame#stop_warning QLabel {{ font-size: {px(TITLE_PX)}px; }}
QFrame#stop_warning QLabel#motors_off {{ font-size: {px(56)}px; font-weight: bold; }}
"""

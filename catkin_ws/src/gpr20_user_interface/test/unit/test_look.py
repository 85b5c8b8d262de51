import re

import pytest
from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QIcon
from PyQt5.QtTest import QTest

from gpr20_user_interface.look.icons import FOLDER, icon
from gpr20_user_interface.look.look import (
    TOUCH_PX,
    Look,
    Mark,
    TextColours,
    Theme,
    look_of,
    scale_for,
)
from gpr20_user_interface.look.style_sheet import TEMPLATE, style_sheet

# WCAG 2.1: 1.4.6 for text (level AAA), 1.4.11 for what distinguishes a mark from its surroundings.
TEXT_CONTRAST = 7.0
MARK_CONTRAST = 3.0


def luminance(colour):
    """Relative luminance by WCAG 2.1."""
    channels = [int(colour[start : start + 2], 16) / 255.0 for start in (1, 3, 5)]
    linear = [one / 12.92 if one <= 0.03928 else ((one + 0.055) / 1.055) ** 2.4 for one in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    lighter, darker = sorted((luminance(one), luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def test_contrast_is_computed_as_wcag_says():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


def test_every_text_and_every_mark_is_seen():
    for theme in Theme:
        for colours in TextColours:
            assert contrast(*colours.of(theme)) >= TEXT_CONTRAST, colours
        for mark in set(Mark) - {Mark.PAPER}:
            assert contrast(mark.of(theme), Mark.PAPER.of(theme)) >= MARK_CONTRAST, mark


def test_style_sheet_has_no_colour_beside_the_palette():
    for theme in Theme:
        palette = {mark.of(theme) for mark in Mark}
        palette.update(colour for colours in TextColours for colour in colours.of(theme))
        sheet = style_sheet(Look(theme))
        assert set(re.findall(r"#[0-9a-fA-F]{6}\b", sheet)) <= palette
        assert not re.search(r"(color|background):\s*[a-z]", sheet)


def test_ink_never_comes_without_its_ground():
    for rule in re.findall(r"\{([^}]*)\}", style_sheet(Look())):
        if re.search(r"(?<![-\w])color:", rule):
            assert "background:" in rule


def test_everything_scales_with_the_window(window):
    for size, scale in (((480, 320), 0.6), ((800, 480), 1.0), ((1280, 800), 1.6)):
        window.resize(*size)
        QTest.qWait(1)
        assert (window.width(), window.height()) == size
        assert window.look.scale == pytest.approx(scale)
        assert look_of(window.top_bar) is window.look
        assert window.control.start.height() >= round(TOUCH_PX * scale)
        assert window.top_bar.stop.geometry().right() < size[0]
    for size in ((1, 1), (480, 320), (1024, 600), (4000, 3000)):
        assert 0.57 <= scale_for(*size) <= 1.8


def test_theme_changes_while_the_window_is_open(window):
    window.use_look(Look(Theme.NIGHT, window.look.scale))
    QTest.qWait(1)
    paper = window.grab().toImage().pixelColor(window.width() // 2, window.height() - 3)
    assert paper.name() == Mark.PAPER.of(Theme.NIGHT)
    assert Qt.GlobalColor.white != paper


def test_every_name_of_the_style_sheet_is_that_of_a_widget():
    package = TEMPLATE.parents[1]
    source = "".join(path.read_text(encoding="utf-8") for path in package.glob("**/*.py"))
    rules = re.sub(r"/[*].*?[*]/", "", TEMPLATE.read_text(encoding="utf-8"), flags=re.DOTALL)
    names = {*re.findall(r"#(\w+)", rules), *re.findall(r"\[(\w+)=", rules)}
    assert names and {one for one in names if f'"{one}"' not in source} == set()


def test_a_sign_has_the_colour_that_it_is_asked_for_also_where_it_is_disabled(application):
    for path in FOLDER.glob("*.svg"):
        drawn = icon(path.stem, "#8f0000", 32)
        for mode in (QIcon.Normal, QIcon.Disabled):
            picture = drawn.pixmap(QSize(32, 32), mode).toImage()
            pixels = [picture.pixelColor(x, y) for x in range(32) for y in range(32)]
            solid = {one.name() for one in pixels if one.alpha() == 255}
            assert solid == {"#8f0000"}, path.name
    with pytest.raises(FileNotFoundError):
        icon("no such sign", "#8f0000", 32)

import re

import pytest

pytest.importorskip("PyQt5")

from gpr20_user_interface.views.style import BORDER, PAPER, STYLE_SHEET, TextColours

# WCAG 2.1, level AA: 1.4.3 for text, 1.4.11 for what distinguishes a control from its surroundings.
TEXT_CONTRAST = 4.5
LINE_CONTRAST = 3.0


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


@pytest.mark.parametrize("colours", list(TextColours))
def test_every_text_is_readable(colours):
    assert contrast(colours.value.ink, colours.value.ground) >= TEXT_CONTRAST


def test_borders_of_controls_are_seen():
    assert contrast(BORDER, PAPER) >= LINE_CONTRAST


def test_style_sheet_has_no_colour_beside_the_palette():
    palette = {BORDER, PAPER}
    for colours in TextColours:
        palette.update(colours.value)
    used = set(re.findall(r"#[0-9a-fA-F]{6}\b", STYLE_SHEET))
    assert used <= palette
    assert not re.search(r"(color|background):\s*[a-z]", STYLE_SHEET)


def test_ink_never_stands_without_its_ground():
    for rule in re.findall(r"\{([^}]*)\}", STYLE_SHEET):
        if re.search(r"(?<![-\w])color:", rule):
            assert "background:" in rule

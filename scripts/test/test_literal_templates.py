"""A template that xgettext would not find is refused with what to do."""

from __future__ import annotations

import pytest
from literal_templates import complaints

LITERAL = "write the template as one literal string"
BEFORE = "put the text into a variable of its own, before the f-string"


@pytest.mark.parametrize(
    "source, remedy",
    [
        ("Message(text, height_m=1.0)", LITERAL),
        ("Message(\n    TEXTS[0],\n)", LITERAL),
        ("self.tr(f'{name} fails')", LITERAL),
        ("Message('{} fails'.format(name))", LITERAL),
        ("Message('%s fails' % name)", LITERAL),
        ("Message('it fails' if bad else 'it works')", LITERAL),
        ("f'{self.tr(\"it fails\")}: {name}'", BEFORE),
    ],
)
def test_a_template_that_would_not_be_found_is_refused(source, remedy):
    (found,) = complaints(source)
    assert found.startswith(("1: ", "2: "))
    assert remedy in found


def test_a_literal_template_is_found():
    source = "Message(\n    'the height {height_m:g} m '\n    'is wrong', height_m=1.0)\nf'{a}'"
    assert list(complaints(source)) == []

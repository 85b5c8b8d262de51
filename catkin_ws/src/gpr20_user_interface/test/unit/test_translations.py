import string
from pathlib import Path

import pytest
from source_texts import source_texts

from gpr20_user_interface.errors import LanguageError
from gpr20_user_interface.low.translation_file import FOLDER, read_translations
from gpr20_user_interface.views.translation import Language, language_from_code

SPANISH = FOLDER / "es.ts"


def fields(text):
    return sorted(name for _, name, _, _ in string.Formatter().parse(text) if name)


def test_every_text_of_the_window_has_a_spanish_one():
    missing = source_texts() - set(read_translations(SPANISH))
    assert missing == set(), f"add these messages to {SPANISH}"


def test_no_translation_is_left_over():
    assert set(read_translations(SPANISH)) - source_texts() == set()


def test_a_translation_has_the_same_places_to_fill_in():
    for (context, text), translation in read_translations(SPANISH).items():
        assert fields(text) == fields(translation), (context, text)


def test_translations_that_are_not_finished_are_not_used(tmp_path):
    path = tmp_path / "xx.ts"
    path.write_text(
        "<TS><context><name>A</name>"
        "<message><source>one</source><translation type='unfinished'>1</translation></message>"
        "<message><source>two</source><translation>2</translation></message>"
        "<message><source>three</source><translation></translation></message>"
        "</context></TS>"
    )
    assert read_translations(path) == {("A", "two"): "2"}


@pytest.mark.parametrize("text", ["", "<TS>", "no xml"])
def test_file_that_is_no_xml_is_refused(tmp_path, text):
    path = tmp_path / "xx.ts"
    path.write_text(text)
    with pytest.raises(LanguageError, match="cannot be read"):
        read_translations(path)


def test_missing_file_is_refused():
    with pytest.raises(LanguageError, match="cannot be read"):
        read_translations(Path("/does/not/exist.ts"))


@pytest.mark.parametrize("language", list(Language))
def test_language_is_known_by_its_code(language):
    assert language_from_code(language.value) is language


@pytest.mark.parametrize("code", ["", "fr", "ES", 5])
def test_other_languages_are_refused(code):
    with pytest.raises(LanguageError, match="must be one of en"):
        language_from_code(code)

import errno
from string import Formatter

from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common import faults
from gpr20_common.catalogue import (
    FOLDER,
    Language,
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
    read_translations,
)
from gpr20_common.errors import NodeSilentError, os_reason
from gpr20_common.message import Message


def test_the_spanish_catalogue_translates_a_message_and_what_is_in_it():
    message = Message("the file is lost: {reason}", reason=os_reason(OSError(errno.ENOSPC, "full")))
    assert read_catalogue(Language.SPANISH).text(message) == "the file is lost: el disco está lleno"
    assert read_catalogue(Language.ENGLISH).text(message) == "the file is lost: the disk is full"


def test_every_translation_has_the_fields_of_its_template():
    for template, translation in read_translations(FOLDER / "es.po").items():
        fields = [
            sorted(part[1:3] for part in Formatter().parse(text) if part[1] is not None)
            for text in (template, translation)
        ]
        assert fields[0] == fields[1], template


@each_case("content", [None, b"no catalogue", b"msgstr", b"\xff"])
def test_a_catalogue_that_cannot_be_read_is_refused(tmp_path, content):
    path = tmp_path / "xx.po"
    if content is not None:
        path.write_bytes(content)
    with raises_fault(faults.FILE_DAMAGED, path):
        read_translations(path)


@each_case("code", ["", "fr", "ES", 5])
def test_a_language_is_found_by_its_code_or_refused(code):
    for language in languages():
        assert language_from_code(language.value) == language
    with raises_fault(faults.CONFIGURATION, repr(code), "en (English), es"):
        language_from_code(code)


@each_case(
    "environment, language",
    [
        ({}, Language.ENGLISH),
        ({"LANG": "es_PE.UTF-8"}, Language.SPANISH),
        ({"LANG": "es_PE.UTF-8", "LC_ALL": "C"}, Language.ENGLISH),
        ({"LANGUAGE": "es:en", "LANG": "en_US"}, Language.SPANISH),
        ({"LANGUAGE": "fr:es:en", "LANG": "en_US"}, Language.SPANISH),
        ({"LANGUAGE": "en:es", "LANG": "es_PE"}, Language.ENGLISH),
        ({"LANGUAGE": "es", "LANG": "C"}, Language.ENGLISH),
        ({"LANG": "fr"}, Language.ENGLISH),
    ],
)
def test_a_terminal_has_the_language_of_its_environment(environment, language):
    assert language_from_environment(environment) == language


@each_case(
    "error, shown",
    [
        (OSError(errno.ENOTTY, "Inappropriate ioctl"), "Inappropriate ioctl"),
        (OSError(), "OSError"),
        (NodeSilentError(Message("{node} does not answer", node="/x")), "/x"),
    ],
)
def test_other_errors_of_the_system_say_what_they_know(error, shown):
    assert shown in str(os_reason(error))

"""What the windows, pages and terminals of the tests show has Spanish.

A conftest.py that imports the fixture holds this for all its tests.
"""

from __future__ import annotations

import functools
import re
from typing import Iterable, Iterator, Set

import pytest
from translations import COMPLETE, module_files, templates_of

from gpr20_common.catalogue import Catalogue, read_translations

WORD, FIELD = re.compile(r"[^\W\d_]{2,}"), re.compile(r"\{[^}]*\}")
NAMES = re.compile(r"\S*[./_\d]\S+")


@pytest.fixture(autouse=True)
def shown_is_translated(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Expect Spanish of every sentence of a program that is looked up to be shown."""
    looked_up: Set[str] = set()
    look_up = Catalogue.template

    def template(catalogue: Catalogue, one: str) -> str:
        looked_up.add(one)
        return look_up(catalogue, one)

    monkeypatch.setattr(Catalogue, "template", template)
    yield
    lacking = looked_up - read_translations(COMPLETE).keys()
    # Tests make sentences up, too.
    assert not lacking or not lacking & _of_programs()


def english_words(texts: Iterable[str]) -> Set[str]:
    """Return the words that only English sentences of the project have; no codes and addresses."""
    return set(WORD.findall(NAMES.sub(" ", "\n".join(texts)).lower())) & _english()


@functools.lru_cache(maxsize=None)
def _english() -> Set[str]:
    ours, theirs = ("\n".join(one).lower() for one in zip(*read_translations(COMPLETE).items()))
    english, spanish = (WORD.findall(FIELD.sub(" ", one)) for one in (ours, theirs))
    return set(english) - set(spanish)


@functools.lru_cache(maxsize=None)
def _of_programs() -> Set[str]:
    return templates_of(module_files().values())

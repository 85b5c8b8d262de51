"""What is kept of a password, and which ones are taken."""

from __future__ import annotations

import dataclasses
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from login_kit import CHEAP

from gpr20_web.errors import AccountError
from gpr20_web.low.passwords import LEAST_DIFFERENT, PasswordHash, check_password

ANY_TEXT = st.text(st.characters(), max_size=250)


@given(ANY_TEXT, ANY_TEXT)
def test_a_hash_fits_its_password_and_no_other_in_any_script(one: str, other: str) -> None:
    made = PasswordHash.parse(str(CHEAP.of(one)))
    assert made.fits(one)
    same = unicodedata.normalize("NFC", one) == unicodedata.normalize("NFC", other)
    assert made.fits(other) == same


def test_the_same_password_has_another_hash_each_time() -> None:
    assert CHEAP.of("x") != CHEAP.of("x")
    assert "secret words" not in str(CHEAP.of("secret words"))


def test_new_hashes_cost_what_owasp_recommends_and_take_another_effort_from_the_text() -> None:
    made = str(PasswordHash().of("correct horse"))
    assert made.startswith("scrypt:32768:8:3:")
    assert PasswordHash.parse(made).fits("correct horse")
    assert PasswordHash.parse(str(PasswordHash(n=64).of("correct horse"))).fits("correct horse")


def test_an_accent_fits_however_a_keyboard_writes_it() -> None:
    assert CHEAP.of("contraseña").fits(unicodedata.normalize("NFD", "contraseña"))


@given(st.one_of(ANY_TEXT, st.from_regex(r"scrypt:-?\d+:\d+:\d+:[A-Za-z0-9+/=]*:.*")))
def test_a_text_that_is_no_hash_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        PasswordHash.parse(text)


@pytest.mark.parametrize(
    "effort", [{"n": 1 << 21}, {"n": 3}, {"n": 1}, {"n": -2}, {"r": 0}, {"r": 33}, {"p": 17}]
)
def test_a_hash_that_would_need_another_computer_is_refused(effort: dict) -> None:
    made = dataclasses.replace(CHEAP.of("x"), **effort)
    with pytest.raises(ValueError):
        PasswordHash.parse(str(made))


# Letters that are one character in each way of writing them.
@given(
    st.text(
        st.characters(max_codepoint=0x17F, blacklist_categories=["Cc"]), min_size=12, max_size=200
    ).filter(lambda text: len(set(text)) >= LEAST_DIFFERENT),
    st.text("abc.-_", min_size=2, max_size=11),
)
def test_every_password_of_12_to_200_characters_with_5_different_ones_is_taken(
    password: str, name: str
) -> None:
    check_password(password, name)


@pytest.mark.parametrize(
    "password",
    [
        *("", "abcdefghijk", "abcde" * 41, "n\u0303o\u0303abc" * 2, "Anastasia.Ortiz"),
        *("correct horse\ud800", "\0" * 20, "correct\thorse", "correct horse\x1b", " " * 12),
        "abcdabcdabcd",
    ],
)
def test_short_long_poor_and_broken_passwords_and_the_name_are_refused(password: str) -> None:
    with pytest.raises(AccountError) as refused:
        check_password(password, "anastasia.ortiz")
    assert password not in str(refused.value) or not password


def test_a_refused_password_is_described_by_its_length_and_what_is_allowed() -> None:
    said = "the password has 4 characters, 3 different ones; it must have 12 to 200, at least 5"
    with pytest.raises(AccountError, match=said):
        check_password("noon"[:3] + "x", "ana")

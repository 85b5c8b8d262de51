"""The accounts, their file, and what is kept of a password."""

from __future__ import annotations

import dataclasses
import json
import os
import stat
import unicodedata
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from web_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.files.folder_lock import locked
from gpr20_web.errors import AccountError, AccountsFileError, WrongLoginError
from gpr20_web.low import account_file
from gpr20_web.low.account_file import checked_name, role_of
from gpr20_web.low.passwords import LEAST_DIFFERENT, PasswordHash, check_password
from gpr20_web.mid.accounts import Accounts
from gpr20_web.roles import Role


@pytest.fixture
def accounts(tmp_path: Path) -> Accounts:
    return make_accounts(tmp_path)


def _file(tmp_path: Path) -> Path:
    return tmp_path / "web" / "accounts.json"


def test_an_account_can_be_logged_in_to_with_its_password_alone(
    accounts: Accounts, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert accounts.all() == []
    made = accounts.add("Ana", Role.VIEW, PASSWORD)
    assert accounts.check("ana", PASSWORD) == made == accounts.check("ANA", PASSWORD)
    hashed = []
    fits = PasswordHash.fits

    def count(known: PasswordHash, password: str) -> bool:
        hashed.append((known.n, known.r, known.p))
        return fits(known, password)

    monkeypatch.setattr(PasswordHash, "fits", count)
    said = set()
    for name, password in [("ana", OTHER_PASSWORD), ("ana", ""), ("eva", PASSWORD), ("", "")]:
        with pytest.raises(WrongLoginError) as refused:
            accounts.check(name, password)
        said.add(str(refused.value))
    # A wrong name says the same and is as slow as a wrong password.
    assert len(said) == 1
    assert hashed == [(CHEAP.n, CHEAP.r, CHEAP.p)] * 4


def test_only_their_owner_reads_folder_and_file_and_the_folder_of_another_is_left_alone(
    accounts: Accounts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "web").mkdir(0o755)
    with monkeypatch.context() as other, pytest.raises(AccountsFileError, match="belongs to"):
        other.setattr("os.geteuid", lambda: 12345)
        accounts.add("ana", Role.OPERATE, PASSWORD)
    assert not _file(tmp_path).exists()
    accounts.add("ana", Role.OPERATE, PASSWORD)
    assert stat.S_IMODE((tmp_path / "web").stat().st_mode) == 0o700
    assert stat.S_IMODE(_file(tmp_path).stat().st_mode) == 0o600
    assert PASSWORD not in _file(tmp_path).read_text()


def test_another_program_s_change_is_noticed_at_once_and_a_file_that_is_gone_is_no_empty_list(
    accounts: Accounts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = make_accounts(tmp_path)
    other.add("ana", Role.OPERATE, PASSWORD)
    assert accounts.find("ana") is not None
    with monkeypatch.context() as patch:
        # It is read only when it has changed.
        patch.setattr(account_file, "read_regular", lambda _path: pytest.fail("it was read"))
        assert accounts.find("ana") is not None
    other.remove("ana")
    assert accounts.find("ana") is None and accounts.all() == []
    _file(tmp_path).unlink()
    for act in (accounts.all, lambda: accounts.add("eva", Role.OPERATE, PASSWORD)):
        with pytest.raises(AccountsFileError, match="the file is gone"):
            act()
    make_accounts(tmp_path).add("eva", Role.OPERATE, PASSWORD)
    assert [one.name for one in accounts.all()] == ["eva"]


def test_changes_at_the_same_time_are_all_kept(tmp_path: Path) -> None:
    names = [f"user{number}" for number in range(12)]
    with ThreadPoolExecutor(len(names)) as pool:
        adds = [make_accounts(tmp_path).add for _name in names]
        list(pool.map(lambda add, name: add(name, Role.VIEW, PASSWORD), adds, names))
    assert [one.name for one in make_accounts(tmp_path).all()] == sorted(names)


def test_a_file_that_another_program_holds_is_named(
    accounts: Accounts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "web").mkdir()
    monkeypatch.setattr(account_file, "SHORT_WAIT_S", 0.0)
    with locked(tmp_path / "web"), pytest.raises(AccountsFileError, match="another program"):
        accounts.add("eva", Role.VIEW, PASSWORD)


@each_case("name", ["", "a", ".a", "-a", "_a", "a b", "a/b", "ñu", "a" * 41, "a\n"])
def test_names_that_could_be_something_else_are_refused(accounts: Accounts, name: str) -> None:
    with raises_fault(NOT_ALLOWED, repr(name), "2 to 40 letters", error=AccountError):
        accounts.add(name, Role.VIEW, PASSWORD)


def test_roles_are_known_words_and_nobody_is_none() -> None:
    assert [role_of(one) for one in ("view", "operate")] == list(Role)[1:]
    for word in ("nobody", "admin", "", None, 3, []):
        with raises_fault(NOT_ALLOWED, repr(word), error=AccountError):
            role_of(word)


def _damage(**changes: Any) -> bytes:
    """Return a file with one account of which fields have other values; None: it is missing."""
    entry = {
        **{"name": "ana", "role": "operate", "hash": str(CHEAP.of(PASSWORD))},
        **{"created": "2026-01-01", "generation": 7, **changes},
    }
    entry = {name: value for name, value in entry.items() if value is not None}
    return json.dumps({"format": "gpr20-accounts/1", "accounts": [entry]}).encode()


TWICE = json.loads(_damage())
TWICE["accounts"] *= 2
DAMAGES = [
    (b'{"format": "gpr20-accounts/2"}', "'gpr20-accounts/2'; it must be 'gpr20-accounts/1'"),
    (b'{"format": "gpr20-accounts/1", "accounts": [null]}', ""),
    (b"nonsense", "line 1 column 1"),
    (b"[" * 200_000, ""),
    (json.dumps(TWICE).encode(), ""),
    (_damage(role="boss"), "the role is 'boss'; it must be one of view, operate"),
    (_damage(role="nobody"), ""),
    (_damage(name="Ana"), ""),
    (_damage(hash="scrypt:2:1:1::"), ""),
    (_damage(generation=-1), "generation is -1; it must lie between 0"),
    (_damage(admin=True), ""),
    (_damage(hash=None), ""),
]


@each_case("data, said", DAMAGES)
def test_a_damaged_file_is_named_and_is_never_an_empty_list(
    tmp_path: Path, data: bytes, said: str
) -> None:
    accounts = make_accounts(tmp_path)
    (tmp_path / "web").mkdir(exist_ok=True)
    _file(tmp_path).write_bytes(_damage())
    assert accounts.find("ana") is not None
    _file(tmp_path).write_bytes(data)
    for act in (
        lambda: accounts.find("ana"),
        lambda: accounts.check("ana", PASSWORD),
        lambda: accounts.add("eva", Role.OPERATE, PASSWORD),
        lambda: accounts.remove("ana"),
    ):
        with pytest.raises(AccountsFileError, match=r"accounts\.json") as refused:
            act()
        assert refused.value.message.remedy is not None
        assert said in str(refused.value) and "Error" not in str(refused.value)
        assert str(tmp_path) not in refused.value.message.sentence()


def test_what_is_no_file_is_refused_without_waiting(tmp_path: Path) -> None:
    (tmp_path / "web").mkdir()
    os.mkfifo(str(_file(tmp_path)))
    with pytest.raises(AccountsFileError):
        make_accounts(tmp_path).all()


NAMES = st.one_of(st.sampled_from(["ana", "Eva", "leo.1"]), st.text(max_size=45))
PASSWORDS = st.one_of(st.sampled_from([PASSWORD, OTHER_PASSWORD]), st.text(max_size=210))


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["add", "password", "role", "remove"]),
            NAMES,
            st.sampled_from(list(Role)[1:]),
            PASSWORDS,
        ),
        max_size=12,
    )
)
def test_random_changes_leave_what_a_simple_list_of_accounts_says(
    tmp_path_factory: pytest.TempPathFactory, changes: list
) -> None:
    accounts = make_accounts(tmp_path_factory.mktemp("random"))
    acts = {
        "add": accounts.add,
        "password": lambda name, _role, password: accounts.change(name, password=password),
        "role": lambda name, role, _password: accounts.change(name, role=role),
        "remove": lambda name, *_more: accounts.remove(name),
    }
    model: Dict[str, Tuple[Role, str]] = {}
    for what, name, role, password in changes:
        after = _expected(model, what, name, role, password)
        try:
            acts[what](name, role, password)
            assert after is not None
            model = after
        except AccountError:
            assert after is None
        assert {one.name: one.role for one in accounts.all()} == {
            one: role for one, (role, _password) in model.items()
        }
    for one, (role, password) in model.items():
        assert accounts.check(one, password).role is role


def _expected(
    model: Dict[str, Tuple[Role, str]], what: str, name: str, role: Role, password: str
) -> Optional[Dict[str, Tuple[Role, str]]]:
    """Return what a change leads to; None: it is refused."""
    try:
        small = checked_name(name)
        if what in ("add", "password"):
            check_password(password, small)
    except AccountError:
        return None
    old = model.get(small)
    if (what == "add") is (old is not None):
        return None
    after = {one: kept for one, kept in model.items() if one != small}
    if old is None:
        return {**after, small: (role, password)}
    if what == "password" and password == old[1]:
        return None
    if what != "remove":
        after[small] = (role, old[1]) if what == "role" else (old[0], password)
    return after


ANY_TEXT = st.text(st.characters(), max_size=250)


@given(ANY_TEXT, ANY_TEXT)
def test_a_hash_fits_its_password_and_no_other_in_any_script(one: str, other: str) -> None:
    made = PasswordHash.parse(str(CHEAP.of(one)))
    assert made.fits(one)
    same = unicodedata.normalize("NFC", one) == unicodedata.normalize("NFC", other)
    assert made.fits(other) == same


def test_new_hashes_cost_what_owasp_recommends_and_are_never_the_same() -> None:
    assert CHEAP.of("x") != CHEAP.of("x")
    assert CHEAP.of("contraseña").fits(unicodedata.normalize("NFD", "contraseña"))
    made = str(PasswordHash().of("correct horse"))
    assert made.startswith("scrypt:32768:8:3:")
    assert PasswordHash.parse(made).fits("correct horse")


@given(st.one_of(ANY_TEXT, st.from_regex(r"scrypt:-?\d+:\d+:\d+:[A-Za-z0-9+/=]*:.*")))
def test_a_text_that_is_no_hash_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        PasswordHash.parse(text)


@each_case("effort", [{"n": 1 << 21}, {"n": 3}, {"n": 1}, {"r": 0}, {"r": 33}, {"p": 17}])
def test_a_hash_that_would_need_another_computer_is_refused(effort: Dict[str, int]) -> None:
    with pytest.raises(ValueError):
        PasswordHash.parse(str(dataclasses.replace(CHEAP.of("x"), **effort)))


@given(
    st.text(
        st.characters(max_codepoint=0x17F, blacklist_categories=["Cc"]), min_size=12, max_size=200
    ).filter(lambda text: len(set(text)) >= LEAST_DIFFERENT)
)
def test_every_password_of_12_to_200_characters_with_5_different_ones_is_taken(
    password: str,
) -> None:
    check_password(password, "a.-")


@each_case(
    "password, said",
    [
        ("noox", "4 characters, 3 different ones; it must have 12 to 200, at least 5"),
        *((one, "") for one in ("abcdefghijk", "abcde" * 41, "n\u0303o\u0303abc" * 2)),
        *((one, "") for one in ("Anastasia.Ortiz", "correct horse\ud800", "\0" * 20, " " * 12)),
        *((one, "") for one in ("correct\thorse", "correct horse\x1b", "abcdabcdabcd")),
    ],
)
def test_short_long_poor_and_broken_passwords_and_the_name_are_refused(
    password: str, said: str
) -> None:
    with pytest.raises(AccountError) as refused:
        check_password(password, "anastasia.ortiz")
    assert said in str(refused.value) and password not in str(refused.value)

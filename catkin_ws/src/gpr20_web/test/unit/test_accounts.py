"""The accounts, their file, and what is kept of a password."""

from __future__ import annotations

import stat
import unicodedata
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from unittest import mock

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from web_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.files.durable_files import locked
from gpr20_web.calls import Role
from gpr20_web.faults import AccountError, AccountsFileError, WrongLoginError
from gpr20_web.low import accounts as module
from gpr20_web.low.accounts import OWASP, Accounts, fits, hash_of


@pytest.fixture
def accounts(tmp_path: Path) -> Accounts:
    return make_accounts(tmp_path)


def _file(tmp_path: Path) -> Path:
    return tmp_path / "web" / "accounts.txt"


def test_an_account_can_be_logged_in_to_with_its_password_alone(
    accounts: Accounts, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert accounts.all() == []
    accounts.put("Ana", Role.WATCH, PASSWORD)
    made = accounts.check("ana", PASSWORD)
    assert (made.name, made.role) == ("ana", Role.WATCH) and made == accounts.check("ANA", PASSWORD)
    hashed, said = mock.Mock(side_effect=hash_of), set()
    monkeypatch.setattr(module, "hash_of", hashed)
    for name, password in [("ana", OTHER_PASSWORD), ("ana", ""), ("eva", PASSWORD), ("", "")]:
        with pytest.raises(WrongLoginError) as refused:
            accounts.check(name, password)
        said.add(str(refused.value))
    # A wrong name says the same and is as slow as a wrong password.
    assert (len(said), [one.args[1] for one in hashed.call_args_list]) == (1, [CHEAP] * 4)


def test_only_their_owner_reads_folder_and_file_and_the_folder_of_another_is_left_alone(
    accounts: Accounts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "web").mkdir(0o755)
    with monkeypatch.context() as other, pytest.raises(AccountsFileError, match="belongs to"):
        other.setattr("os.geteuid", lambda: 12345)
        accounts.put("ana", Role.CONTROL, PASSWORD)
    assert not _file(tmp_path).exists()
    accounts.put("ana", Role.CONTROL, PASSWORD)
    assert stat.S_IMODE((tmp_path / "web").stat().st_mode) == 0o700
    assert stat.S_IMODE(_file(tmp_path).stat().st_mode) == 0o600
    assert PASSWORD not in _file(tmp_path).read_text()


def test_another_program_s_change_is_noticed_at_once_and_a_file_that_is_gone_is_no_empty_list(
    accounts: Accounts, tmp_path: Path
) -> None:
    other = make_accounts(tmp_path)
    other.put("ana", Role.CONTROL, PASSWORD)
    assert accounts.find("ana") is not None
    other.remove("ana")
    assert accounts.find("ana") is None and accounts.all() == []
    _file(tmp_path).unlink()
    for act in (accounts.all, lambda: accounts.put("eva", Role.CONTROL, PASSWORD)):
        with pytest.raises(AccountsFileError, match="no such file"):
            act()


def test_changes_at_the_same_time_are_all_kept_and_a_file_that_is_held_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [f"user{number}" for number in range(12)]
    with ThreadPoolExecutor(len(names)) as pool:
        puts = [make_accounts(tmp_path).put for _name in names]
        list(pool.map(lambda put, name: put(name, Role.WATCH, PASSWORD), puts, names))
    assert [one.name for one in make_accounts(tmp_path).all()] == sorted(names)
    monkeypatch.setattr(module, "SHORT_WAIT_S", 0.0)
    with locked(tmp_path / "web"), pytest.raises(AccountsFileError, match="another program"):
        make_accounts(tmp_path).remove(names[0])


FIRST, HASH = b"gpr20-accounts 1\n", hash_of(PASSWORD, CHEAP).encode()
GOOD = FIRST + b"ana control %b\n" % HASH
DAMAGES = [
    *(b"", FIRST.strip(), b"gpr20-accounts 2\n", b"\xff\n", GOOD + b"half", GOOD[:-1]),
    *(GOOD + one for one in (b"\n", GOOD[len(FIRST) :], b"eva watch 00\n")),
    *(GOOD.replace(one, b"\xff") for one in (b"ana", b"control", HASH[-2:])),
]


@each_case("data", DAMAGES)
def test_a_damaged_file_is_named_and_is_never_an_empty_list(tmp_path: Path, data: bytes) -> None:
    accounts = make_accounts(tmp_path)
    (tmp_path / "web").mkdir(exist_ok=True)
    _file(tmp_path).write_bytes(GOOD)
    assert accounts.find("ana") is not None
    _file(tmp_path).write_bytes(data)
    for act in (lambda: accounts.find("ana"), lambda: accounts.put("eva", Role.WATCH, PASSWORD)):
        with pytest.raises(AccountsFileError, match=r"accounts\.txt"):
            act()
    assert _file(tmp_path).read_bytes() == data


ANY_TEXT = st.text(st.characters(), max_size=250)


@given(ANY_TEXT, ANY_TEXT)
def test_a_hash_fits_its_password_and_no_other_in_any_script(one: str, other: str) -> None:
    made = hash_of(one, CHEAP)
    assert fits(one, made, CHEAP) and fits(unicodedata.normalize("NFD", one), made, CHEAP)
    same = unicodedata.normalize("NFC", one) == unicodedata.normalize("NFC", other)
    assert fits(other, made, CHEAP) == same
    assert hash_of(one, CHEAP) != made and OWASP == (32768, 8, 3)


REFUSED = (
    *((one, PASSWORD) for one in ("", "a", ".a", "-a", "a b", "a/b", "ñu", "a" * 41, "a\n")),
    *(("anastasia.ortiz", one) for one in ("noox", "abcde" * 41, "n\u0303o\u0303abc" * 2)),
    *(("anastasia.ortiz", one) for one in ("Anastasia.Ortiz", "correct horse\ud800", "\0" * 20)),
    *(("anastasia.ortiz", one) for one in (" " * 12, "correct\thorse", "abcdabcdabcd")),
)


@each_case("name, password", REFUSED)
def test_names_that_could_be_something_else_and_poor_passwords_are_refused(
    accounts: Accounts, name: str, password: str
) -> None:
    with raises_fault(NOT_ALLOWED, error=AccountError):
        accounts.put(name, Role.WATCH, password)
    assert accounts.all() == []

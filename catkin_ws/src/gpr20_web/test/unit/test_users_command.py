"""The command users, as a person types it, and what web.yaml may say."""

from __future__ import annotations

import getpass
import io
import sys
from pathlib import Path
from typing import Callable, Tuple
from unittest import mock

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from web_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.codec import record_from
from gpr20_web.calls import Role
from gpr20_web.faults import WrongLoginError
from gpr20_web.high import users_command
from gpr20_web.low.accounts import Accounts
from gpr20_web.mid.web_parameters import WebParameters

Run = Callable[..., Tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs the command; it returns status, output and complaints."""
    monkeypatch.setattr(users_command, "Accounts", lambda folder: Accounts(folder, CHEAP))

    def run_it(*arguments: str, stdin: bytes = b"") -> Tuple[int, str, str]:
        where = () if "--folder" in arguments else ("--folder", str(tmp_path / "web"))
        monkeypatch.setattr(sys, "argv", ["users", *arguments, *where])
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin)))
        status = users_command.main()
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run_it


def _typed(monkeypatch: pytest.MonkeyPatch, *answers: object) -> None:
    ask = mock.Mock(side_effect=[*answers, EOFError()])
    monkeypatch.setattr(getpass, "getpass", ask)


def test_accounts_are_made_changed_listed_and_removed(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _typed(monkeypatch, PASSWORD, PASSWORD, OTHER_PASSWORD, OTHER_PASSWORD)
    assert run("add", "Ana", "--role", "watch")[::2] == (0, "")
    status, out, _complaint = run("add", "ana", "--role", "control")
    assert (status, "changed" in out, OTHER_PASSWORD in out) == (0, True, False)
    accounts = make_accounts(tmp_path)
    assert accounts.check("ana", OTHER_PASSWORD).role is Role.CONTROL
    with pytest.raises(WrongLoginError):
        accounts.check("ana", PASSWORD)
    assert run("add", "eva", "--role", "watch", "--stdin", stdin=PASSWORD.encode())[0] == 0
    lines = [one.split()[:2] for one in run("list")[1].splitlines()]
    assert lines == [["ana", "control"], ["eva", "watch"]]
    assert run("remove", "eva")[0] == 0
    assert [one.name for one in accounts.all()] == ["ana"]


def test_what_is_no_password_or_no_name_makes_no_account(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for sent in (b"", b"short\n", b"\xff" * 20):
        status, _out, complaint = run("add", "ana", "--role", "control", "--stdin", stdin=sent)
        assert (status, complaint.startswith("users: ")) == (1, True)
    for answers in ((PASSWORD, OTHER_PASSWORD), ()):
        _typed(monkeypatch, *answers)
        status, _out, complaint = run("add", "ana", "--role", "control")
        assert (status, "password" in complaint, "->" in complaint) == (1, True, True)
    _typed(monkeypatch, KeyboardInterrupt())
    assert run("add", "ana", "--role", "watch") == (1, "", "users: nothing was changed\n")
    monkeypatch.setattr(getpass, "getpass", lambda _prompt: pytest.fail("asked"))
    assert run("add", "a b", "--role", "watch")[0] == 1
    assert "there is no account eva" in run("remove", "eva")[2]
    assert make_accounts(tmp_path).all() == []
    # A password is one line of the input.
    for number, end in enumerate([b"", b"\n", b"\r\n", b"\nanother line"]):
        name, sent = f"user{number}", "contraseña larga".encode() + end
        assert run("add", name, "--role", "watch", "--stdin", stdin=sent)[0] == 0
        assert make_accounts(tmp_path).check(name, "contraseña larga")


def test_the_folder_is_that_of_the_page_by_default(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    add = ("add", "ana", "--role", "control", "--stdin", "--folder", "")
    for wrong in ("folder: page", "flder: /page", "- 1", "{"):
        (tmp_path / "web.yaml").write_text(wrong)
        status, _out, complaint = run(*add, stdin=PASSWORD.encode())
        assert (status, complaint.startswith("users: ")) == (1, True)
        assert "Traceback" not in complaint
    assert {one.name for one in tmp_path.iterdir()} == {"web.yaml"}
    for written, folder in (("folder: ~/page", "page"), ("port: 8000", ".gpr20/web")):
        (tmp_path / "web.yaml").write_text(written)
        assert run(*add, stdin=PASSWORD.encode())[0] == 0
        assert (tmp_path / folder / "accounts.txt").is_file()


def parameters(**values):
    return record_from(WebParameters, values, "web")


WRONG = {
    "address": ("", "localhost", "010.0.0.1", "10.0.0.1:8443", "::g", 8443, None),
    "port": (80, 65536, "8443", True),
    "folder": ("", "./web", "~other/web", "/web\n"),
    "session_hours": (0, 169, float("nan")),
}


@each_case("name, value", [(name, value) for name in WRONG for value in WRONG[name]])
def test_what_makes_no_sense_is_refused_by_its_name(name, value):
    with raises_fault((NOT_ALLOWED, CONFIGURATION), name, error=InvalidValueError):
        parameters(**{name: value})


def test_people_read_an_address_that_a_browser_can_open():
    # Without a file, only this computer sees the page.
    assert parameters().address == "127.0.0.1"
    for address, read in (("192.168.7.2",) * 2, ("fd00::20",) * 2, ("0.0.0.0", "server")):
        assert parameters(address=address).reached_at("server") == read

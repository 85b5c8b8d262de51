"""The command users, as a person types it, and what web.yaml may say."""

from __future__ import annotations

import getpass
import io
import sys
from pathlib import Path
from typing import Callable, Tuple
from unittest import mock

import pytest
from web_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

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
    for answers in ((PASSWORD, OTHER_PASSWORD), (), (KeyboardInterrupt(),)):
        _typed(monkeypatch, *answers)
        assert run("add", "ana", "--role", "control")[0] == 1
    assert "there is no account eva" in run("remove", "eva")[2]
    assert make_accounts(tmp_path).all() == []
    # A password is one line of the input.
    for number, end in enumerate([b"", b"\n", b"\r\n", b"\nanother line"]):
        name, sent = f"user{number}", "contraseña larga".encode() + end
        assert run("add", name, "--role", "watch", "--stdin", stdin=sent)[0] == 0
        assert make_accounts(tmp_path).check(name, "contraseña larga")


def test_the_folder_is_that_of_the_page_which_only_this_computer_sees_by_default(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    add = ("add", "ana", "--role", "control", "--stdin", "--folder", "")
    for written, status in (("{", 1), ("folder: page", 1), ("address: x", 1), ("folder: ~/a", 0)):
        (tmp_path / "web.yaml").write_text(written)
        assert run(*add, stdin=PASSWORD.encode())[0] == status
    assert (tmp_path / "a/accounts.txt").is_file()
    assert {one.name for one in tmp_path.iterdir()} == {"web.yaml", "a"}
    assert WebParameters() == WebParameters("127.0.0.1", 8443, "~/.gpr20/web", 12.0)

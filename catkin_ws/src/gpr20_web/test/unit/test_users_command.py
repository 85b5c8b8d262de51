"""The command users, as a person types it."""

from __future__ import annotations

import getpass
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Callable, List, Optional, Tuple

import pytest
from login_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

from gpr20_web.errors import WrongLoginError
from gpr20_web.high import users_command
from gpr20_web.mid.accounts import Accounts
from gpr20_web.roles import Role

Run = Callable[..., Tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs the command; it returns status, output and complaints."""
    monkeypatch.setattr(users_command, "Accounts", lambda file, clock: Accounts(file, clock, CHEAP))

    def run_it(*arguments: str, stdin: bytes = b"") -> Tuple[int, str, str]:
        where = () if "--folder" in arguments else ("--folder", str(tmp_path / "web"))
        monkeypatch.setattr(sys, "argv", ["users", *arguments, *where])
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin)))
        status = users_command.main()
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run_it


def _typed(monkeypatch: pytest.MonkeyPatch, *answers: str) -> None:
    left = list(answers)

    def ask(_prompt: str) -> str:
        if not left:
            raise EOFError
        return left.pop(0)

    monkeypatch.setattr(getpass, "getpass", ask)


def test_accounts_are_made_listed_changed_and_removed(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _typed(monkeypatch, PASSWORD, PASSWORD, OTHER_PASSWORD, OTHER_PASSWORD)
    assert run("add", "Ana", "--role", "admin")[::2] == (0, "")
    assert run("password", "ana")[::2] == (0, "")
    accounts = make_accounts(tmp_path)
    assert accounts.check("ana", OTHER_PASSWORD).role is Role.ADMIN
    with pytest.raises(WrongLoginError):
        accounts.check("ana", PASSWORD)
    status, out, _complaint = run(
        "add", "eva", "--role", "view", "--stdin", stdin=PASSWORD.encode()
    )
    assert (status, PASSWORD in out) == (0, False)
    assert run("role", "eva", "operate")[0] == 0
    lines = [one.split()[:2] for one in run("list")[1].splitlines()]
    assert lines == [["ana", "admin"], ["eva", "operate"]]
    assert run("remove", "eva")[0] == 0
    assert [one.name for one in accounts.all()] == ["ana"]


def test_a_password_is_one_line_of_the_input_with_or_without_its_end(
    run: Run, tmp_path: Path
) -> None:
    for number, end in enumerate([b"", b"\n", b"\r\n", b"\nanother line"]):
        name, sent = f"user{number}", "contraseña larga".encode() + end
        assert run("add", name, "--role", "view", "--stdin", stdin=sent)[0] == 0
        assert make_accounts(tmp_path).check(name, "contraseña larga")


@pytest.mark.parametrize("sent", [b"", b"short\n", b"ana\n", b"\xff" * 20, b"x" * 201])
def test_a_password_that_is_none_makes_no_account(run: Run, tmp_path: Path, sent: bytes) -> None:
    status, _out, complaint = run("add", "ana", "--role", "admin", "--stdin", stdin=sent)
    assert (status, complaint.startswith("users: ")) == (1, True)
    assert make_accounts(tmp_path).all() == []


def test_the_last_account_can_be_removed_and_leaves_an_empty_list(run: Run, tmp_path: Path) -> None:
    accounts = make_accounts(tmp_path)
    accounts.add("ana", Role.VIEW, PASSWORD)
    assert run("remove", "ana")[0] == 0
    assert accounts.all() == []
    assert json.loads((tmp_path / "web" / "accounts.json").read_text())["accounts"] == []


@pytest.mark.parametrize("answers", [(PASSWORD, OTHER_PASSWORD), (PASSWORD,), ()])
def test_two_different_passwords_or_none_make_no_account(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answers: List[str]
) -> None:
    _typed(monkeypatch, *answers)
    status, _out, complaint = run("add", "ana", "--role", "admin")
    assert (status, "password" in complaint, "->" in complaint) == (1, True, True)
    assert make_accounts(tmp_path).all() == []


def test_the_question_ends_with_control_c(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_prompt: str) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(getpass, "getpass", interrupt)
    assert run("add", "ana", "--role", "view") == (1, "", "users: nothing was changed\n")
    assert make_accounts(tmp_path).all() == []


def test_a_name_that_is_taken_or_missing_is_said_before_a_password_is_asked_for(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_accounts(tmp_path).add("ana", Role.ADMIN, PASSWORD)
    monkeypatch.setattr(getpass, "getpass", lambda _prompt: pytest.fail("asked"))
    for arguments in (
        ("add", "ANA", "--role", "view"),
        ("password", "eva"),
        ("add", "a b", "--role", "view"),
    ):
        assert run(*arguments)[0] == 1
    for arguments in (("role", "eva", "view"), ("remove", "eva")):
        assert "there is no account eva" in run(*arguments)[2]


@pytest.mark.parametrize("arguments", [("remove", "ana"), ("role", "ana", "view")])
def test_the_last_administrator_can_go_here_with_a_warning(
    run: Run, tmp_path: Path, arguments: List[str]
) -> None:
    make_accounts(tmp_path).add("ana", Role.ADMIN, PASSWORD)
    status, _out, complaint = run(*arguments)
    assert (status, "no account may manage" in complaint) == (0, True)


def test_a_list_of_nobody_says_so(run: Run, tmp_path: Path) -> None:
    assert run("list") == (0, "", f"users: there are no accounts in {tmp_path / 'web'}\n")


def test_a_damaged_file_is_named_with_its_remedy_and_stays(run: Run, tmp_path: Path) -> None:
    (tmp_path / "web").mkdir()
    file = tmp_path / "web" / "accounts.json"
    file.write_text("damaged")
    for arguments in (("list",), ("remove", "ana"), ("role", "ana", "view")):
        status, _out, complaint = run(*arguments)
        assert (status, str(file) in complaint, "->" in complaint) == (1, True, True)
    assert file.read_text() == "damaged"


@pytest.mark.parametrize(
    ("written", "folder"),
    [(None, ".gpr20/web"), ("folder: ~/page", "page"), ("port: 8000", ".gpr20/web")],
)
def test_the_folder_is_that_of_the_page_by_default(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: Optional[str], folder: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    if written is not None:
        (tmp_path / "web.yaml").write_text(written)
    arguments = ["add", "ana", "--role", "admin", "--stdin", "--folder", ""]
    assert run(*arguments, stdin=PASSWORD.encode())[0] == 0
    assert (tmp_path / folder / "accounts.json").is_file()


@pytest.mark.parametrize("written", ["folder: page", "flder: /page", "- 1", "{", "folder: [1]"])
def test_a_wrong_configuration_is_named_and_no_account_made(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: str
) -> None:
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    (tmp_path / "web.yaml").write_text(written)
    arguments = ["add", "ana", "--role", "admin", "--stdin", "--folder", ""]
    status, _out, complaint = run(*arguments, stdin=PASSWORD.encode())
    assert (status, complaint.startswith("users: "), "Traceback" in complaint) == (1, True, False)
    assert {one.name for one in tmp_path.iterdir()} == {"web.yaml"}


def test_a_control_character_in_a_name_does_not_reach_the_terminal(run: Run) -> None:
    assert "\x1b" not in run("remove", "a\x1b[2J")[2]


def test_the_program_needs_no_ros() -> None:
    code = (
        "import sys\n"
        "from gpr20_web.high.users_command import main\n"
        "print([one for one in sys.modules if one.startswith(('ros', 'tornado'))])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    assert done.stdout.strip() == "[]"

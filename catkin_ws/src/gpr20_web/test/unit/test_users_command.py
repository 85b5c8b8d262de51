"""The command users, as a person types it, and what web.yaml and notify.txt may say."""

from __future__ import annotations

import getpass
import io
import subprocess
import sys
from pathlib import Path
from typing import Callable, Optional, Tuple

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from web_kit import CHEAP, OTHER_PASSWORD, PASSWORD, make_accounts

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.records import record_from
from gpr20_web.errors import WrongLoginError
from gpr20_web.high import users_command
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.web_parameters import NOTIFY_FILE, WebParameters
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


@each_case("sent", [b"", b"short\n", b"ana\n", b"\xff" * 20, b"x" * 201])
def test_a_password_that_is_none_makes_no_account(run: Run, tmp_path: Path, sent: bytes) -> None:
    status, _out, complaint = run("add", "ana", "--role", "admin", "--stdin", stdin=sent)
    assert (status, complaint.startswith("users: ")) == (1, True)
    assert make_accounts(tmp_path).all() == []


def test_two_different_passwords_none_or_control_c_make_no_account(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for answers in ((PASSWORD, OTHER_PASSWORD), (PASSWORD,), ()):
        _typed(monkeypatch, *answers)
        status, _out, complaint = run("add", "ana", "--role", "admin")
        assert (status, "password" in complaint, "->" in complaint) == (1, True, True)

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


def test_the_last_administrator_can_go_here_with_a_warning(run: Run, tmp_path: Path) -> None:
    make_accounts(tmp_path).add("ana", Role.ADMIN, PASSWORD)
    make_accounts(tmp_path).add("eva", Role.ADMIN, PASSWORD)
    assert run("remove", "eva")[2] == ""
    for arguments in (("role", "ana", "view"), ("role", "ana", "admin"), ("remove", "ana")):
        status, _out, complaint = run(*arguments)
        assert (status, "no account may manage" in complaint) == (0, arguments[-1] != "admin")
    assert run("list") == (0, "", f"users: there are no accounts in {tmp_path / 'web'}\n")


def test_a_damaged_file_is_named_with_its_remedy_and_stays(run: Run, tmp_path: Path) -> None:
    (tmp_path / "web").mkdir()
    file = tmp_path / "web" / "accounts.json"
    file.write_text("damaged")
    for arguments in (("list",), ("remove", "ana"), ("role", "ana", "view")):
        status, _out, complaint = run(*arguments)
        assert (status, str(file) in complaint, "->" in complaint) == (1, True, True)
    assert file.read_text() == "damaged"


@each_case(
    "written, folder",
    [(None, ".gpr20/web"), ("folder: ~/page", "page"), ("port: 8000", ".gpr20/web")],
)
def test_the_folder_is_that_of_the_page_by_default(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: Optional[str], folder: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    if written is not None:
        (tmp_path / "web.yaml").write_text(written)
    arguments = ["add", f"ana{len(str(written))}", "--role", "admin", "--stdin", "--folder", ""]
    assert run(*arguments, stdin=PASSWORD.encode())[0] == 0
    assert (tmp_path / folder / "accounts.json").is_file()


@each_case("written", ["folder: page", "flder: /page", "- 1", "{", "folder: [1]"])
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


def parameters(**values):
    return record_from(WebParameters, values, "web")


def test_without_a_file_only_this_computer_sees_the_page():
    assert parameters() == WebParameters()
    assert WebParameters().address == "127.0.0.1"


@each_case("address", ["0.0.0.0", "192.168.1.10", "::1", "::", "fd00::20"])
def test_the_address_of_an_interface_is_taken(address):
    assert parameters(address=address).address == address


WRONG = {
    "address": ("", "localhost", "10.0.0.256", "010.0.0.1", "10.0.0.1:8443", "::g", 8443, None),
    "port": (0, 80, 1023, 65536, 8443.0, "8443", True),
    "folder": ("", "web", "./web", "~other/web", "/web\n", 1),
    "idle_minutes": (0, 0.5, 1441, float("nan"), "30"),
    "session_hours": (0, 169, float("inf"), True),
    "view_may_stop": (1, "yes"),
    "notify": (["mailto://me:password@example.org"],),
}


@each_case("name, value", [(name, value) for name in WRONG for value in WRONG[name]])
def test_what_makes_no_sense_is_refused_by_its_name(name, value):
    with raises_fault((NOT_ALLOWED, CONFIGURATION), name, error=InvalidValueError):
        parameters(**{name: value})


@pytest.fixture
def page(tmp_path):
    return parameters(folder=str(tmp_path))


def test_the_folder_is_below_the_home_of_who_runs_the_page(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert WebParameters().path == tmp_path / ".gpr20/web"


def test_nobody_is_notified_without_the_file(page):
    assert page.notified() == ()


def test_each_line_of_the_file_is_somebody_to_notify(page, tmp_path):
    (tmp_path / NOTIFY_FILE).write_text("# mail\n mailto://me:pw@example.org \n\nntfy://topic\n")
    assert page.notified() == ("mailto://me:pw@example.org", "ntfy://topic")


def test_bytes_that_are_no_text_spoil_their_line_alone(page, tmp_path):
    (tmp_path / NOTIFY_FILE).write_bytes(b"\xff\nntfy://topic\n")
    assert page.notified() == ("\N{REPLACEMENT CHARACTER}", "ntfy://topic")


def test_a_file_that_cannot_be_read_is_an_error(page, tmp_path):
    (tmp_path / NOTIFY_FILE).mkdir()
    with raises_fault(CONFIGURATION, NOTIFY_FILE, error=InvalidValueError):
        page.notified()


@pytest.mark.parametrize(
    ("address", "reached"),
    [("192.168.7.2", "192.168.7.2"), ("::1", "::1"), ("0.0.0.0", "server"), ("::", "server")],
)
def test_people_read_an_address_that_a_browser_can_open(address, reached):
    assert WebParameters(address=address).reached_at("server") == reached

"""What web.yaml may say, and whom notify.txt names."""

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.records import record_from
from gpr20_web.mid.web_parameters import NOTIFY_FILE, WebParameters


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


def test_a_bad_address_says_that_ipv6_is_allowed_too():
    for address in ("localhost", "::g"):
        with raises_fault(NOT_ALLOWED, "127.0.0.1 or ::1", error=InvalidValueError):
            parameters(address=address)


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

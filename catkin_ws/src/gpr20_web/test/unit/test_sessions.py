"""Sessions: OWASP's list, and random sequences against a simple model.

That each login has another token, that logout, a change of the account, idleness and age end a
session and nothing else does, is what the model at the end says.
"""

from __future__ import annotations

import json
import random
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

import pytest
from case_kit import each_case
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from run_seed import SEED
from web_kit import OTHER_PASSWORD, PASSWORD, ManualClock, NoFile, make_accounts

from gpr20_common.message import Message
from gpr20_web.calls import Person
from gpr20_web.errors import NotLoggedInError
from gpr20_web.low import session_file
from gpr20_web.low.account_file import Account
from gpr20_web.low.session_file import SessionFile
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.sessions import KEPT_S, MOST_OF_PERSON, MOST_SESSIONS, Sessions
from gpr20_web.roles import Role

IDLE_S, LONGEST_S = 1800.0, 43200.0
ADDRESS = "10.0.0.7"


class World:
    """Accounts in a file and their sessions in another one.

    Attributes:
        file: That of the sessions.
        reported: Why they could not be kept.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.clock = folder, ManualClock()
        self.file = folder / "web" / "sessions.json"
        self.reported: List[Message] = []
        self.ana = make_accounts(folder).add("ana", Role.OPERATE, PASSWORD)
        self.restart()

    def restart(self) -> None:
        """Begin, or kill the node and begin again."""
        self.accounts: Accounts = make_accounts(self.folder)
        file = SessionFile(self.folder / "web", self.reported.append)
        self.sessions = Sessions(self.accounts.find, self.clock, IDLE_S, LONGEST_S, file)

    def is_in(self, token: str) -> bool:
        """Return whether a token is that of a session, without using it."""
        try:
            self.sessions._check(token)
        except NotLoggedInError:
            return False
        return True


@pytest.fixture
def world(tmp_path: Path) -> World:
    return World(tmp_path)


def test_a_session_has_name_role_and_address_and_outlives_the_node(world: World) -> None:
    token = world.sessions.begin(world.ana)
    for _kill in range(2):
        assert world.sessions.find(token, ADDRESS) == Person("ana", Role.OPERATE, token, ADDRESS)
        world.restart()


def test_owasp_session_id_has_32_random_bytes_and_only_its_hash_is_kept(world: World) -> None:
    (world.folder / "web").chmod(0o755)
    tokens = [world.sessions.begin(world.ana) for _number in range(5)]
    assert len(set(tokens)) == 5
    assert all(len(one.partition(".")[0]) == 43 for one in tokens)
    kept = repr(world.sessions.__dict__) + world.file.read_text()
    assert not any(one in kept or one.partition(".")[0] in kept for one in tokens)
    # Nobody else reads the file with the key.
    assert stat.S_IMODE(world.file.stat().st_mode) == 0o600
    assert [one.name for one in world.file.parent.glob(".*")] == []


def test_who_is_logged_in_and_may_have_to_stop_stays_so_without_the_file_of_the_accounts(
    world: World, tmp_path: Path
) -> None:
    token = world.sessions.begin(world.ana)
    assert world.is_in(token)
    file = tmp_path / "web" / "accounts.json"
    for damage in (file.unlink, lambda: file.write_text("damaged")):
        damage()
        assert world.is_in(token)


def test_a_password_that_changes_during_its_check_begins_no_session(world: World) -> None:
    checked = world.accounts.check("ana", PASSWORD)
    world.accounts.change("ana", password=OTHER_PASSWORD)
    assert not world.is_in(world.sessions.begin(checked))


def test_too_many_sessions_of_all_end_the_oldest(tmp_path: Path) -> None:
    names = [f"user{number}" for number in range(MOST_SESSIONS + 3)]
    accounts = {one: Account(one, Role.VIEW, "", "", 1) for one in names}
    sessions = Sessions(accounts.get, ManualClock(), IDLE_S, LONGEST_S, NoFile())
    tokens = [sessions.begin(one) for one in accounts.values()]
    with pytest.raises(NotLoggedInError):
        sessions.find(tokens[2], ADDRESS)
    assert sessions.find(tokens[3], ADDRESS).name == names[3]


def test_threads_that_log_in_and_out_at_once_disturb_no_others(world: World) -> None:
    kept = world.sessions.begin(world.accounts.add("eva", Role.VIEW, PASSWORD))

    def use(_thread: int) -> None:
        for _number in range(10):
            token = world.sessions.begin(world.ana)
            world.sessions.find(kept, ADDRESS)
            world.sessions.end(token)

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(use, range(4)))
    assert world.is_in(kept)


# Idleness, age, the number of sessions and changes of the role are the model's.
ENDS: Dict[str, Callable[[World, str], Any]] = {
    "logout": lambda world, token: world.sessions.end(token),
    "logout everywhere": lambda world, _token: world.sessions.end_all("ana"),
    "password": lambda world, _token: world.accounts.change("ana", password=OTHER_PASSWORD),
    "another program": lambda world, _token: make_accounts(world.folder).remove("ana"),
    "made again": lambda world, _token: (
        world.accounts.remove("ana"),
        world.accounts.add("ana", Role.OPERATE, PASSWORD),
    ),
}


@each_case("name", sorted(ENDS))
def test_what_has_ended_is_over_at_once_and_stays_so_after_a_restart_of_the_node(
    tmp_path_factory: pytest.TempPathFactory, name: str
) -> None:
    world = World(tmp_path_factory.mktemp("world"))
    token = world.sessions.begin(world.ana)
    other = world.sessions.begin(world.accounts.add("eva", Role.VIEW, PASSWORD))
    ENDS[name](world, token)
    with pytest.raises(NotLoggedInError):
        world.sessions.find(token, ADDRESS)
    for _kill in range(2):
        world.restart()
        assert [world.is_in(token), world.is_in(other)] == [False, True]


def test_a_token_that_was_changed_or_signed_by_another_key_is_refused(world: World) -> None:
    token = world.sessions.begin(world.ana)
    for place in random.Random(SEED).sample(range(len(token)), 30):
        other = "A" if token[place] != "A" else "B"
        assert not world.is_in(token[:place] + other + token[place + 1 :])
    kept = json.loads(world.file.read_text())
    world.file.write_text(json.dumps({**kept, "key": "0" * 64}))
    world.restart()
    assert not world.is_in(token)


def test_a_start_of_the_computer_ends_all_as_its_clock_begins_anew(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    token = world.sessions.begin(world.ana)
    (tmp_path / "boot_id").write_text("another")
    monkeypatch.setattr(session_file, "BOOT", tmp_path / "boot_id")
    world.restart()
    assert not world.is_in(token)
    assert world.reported == []


@each_case("content", ["", "[" * 100_000, '{"boot": 1, "key": "k"}', '{"boot": BOOT, "key": "12"}'])
def test_a_damaged_file_is_reported_and_everybody_logs_in_again(
    tmp_path_factory: pytest.TempPathFactory, content: str
) -> None:
    world = World(tmp_path_factory.mktemp("world"))
    token = world.sessions.begin(world.ana)
    world.file.write_text(content.replace("BOOT", json.dumps(session_file.BOOT.read_text())))
    world.restart()
    assert [one.fault_code for one in world.reported] == ["config.wrong"]
    assert not world.is_in(token)
    token = world.sessions.begin(world.ana)
    world.restart()
    assert world.is_in(token)


def test_on_a_full_disk_people_log_in_and_a_logout_is_kept_when_there_is_space(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    former = world.sessions.begin(world.ana)

    def refuse(*_arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as full:
        full.setattr(session_file, "replace_file", refuse)
        world.sessions.end(former)
        token = world.sessions.begin(world.ana)
    assert [world.is_in(former), world.is_in(token)] == [False, True]
    assert "the disk is full" in str(world.reported[0])
    world.sessions.keep()
    world.restart()
    assert [world.is_in(former), world.is_in(token)] == [False, True]


class SessionMachine(RuleBasedStateMachine):
    """Logs in and out, waits, changes accounts; a list of those who are in says who may."""

    NAMES = ("ana", "eva", "leo")

    @initialize()
    def begin(self) -> None:
        self.clock = ManualClock()
        self.generation = 0
        self.accounts: Dict[str, Account] = {}
        self.file = NoFile()
        self.sessions = self._open()
        # Tokens: name, begin, last use; in the order of the logins.
        self.model: Dict[str, Tuple[str, float, float]] = {}
        self.ended: List[str] = []
        for name in self.NAMES:
            self.renew(name)

    def _open(self) -> Sessions:
        return Sessions(self.accounts.get, self.clock, IDLE_S, LONGEST_S, self.file)

    @rule()
    def restart(self) -> None:
        self.sessions.keep()
        self.sessions = self._open()
        for token, (name, begun_s, used_s) in self.model.items():
            self.model[token] = (name, begun_s, used_s // KEPT_S * KEPT_S)
        self.wait(0.0)

    @rule(name=st.sampled_from(NAMES))
    def renew(self, name: str) -> None:
        """Change an account, or make it again."""
        self.generation += 1
        self.accounts[name] = Account(name, Role.VIEW, "", "", self.generation)
        self._drop(self._of(name))

    @rule(name=st.sampled_from(NAMES))
    def remove(self, name: str) -> None:
        self.accounts.pop(name, None)
        self._drop(self._of(name))

    @rule(name=st.sampled_from(NAMES), times=st.integers(1, 6))
    def log_in(self, name: str, times: int) -> None:
        for _number in range(times if name in self.accounts else 0):
            token = self.sessions.begin(self.accounts[name])
            own = self._of(name)
            self._drop(own[: max(0, len(own) + 1 - MOST_OF_PERSON)])
            self.model[token] = (name, self.clock.time_s, self.clock.time_s)

    @rule(number=st.integers(0, 40))
    def log_out(self, number: int) -> None:
        for token in list(self.model)[number : number + 1]:
            self.sessions.end(token)
            self._drop([token])

    @rule(name=st.sampled_from(NAMES))
    def log_out_everywhere(self, name: str) -> None:
        self.sessions.end_all(name)
        self._drop(self._of(name))

    @rule(number=st.integers(0, 40))
    def use(self, number: int) -> None:
        for token in list(self.model)[number : number + 1]:
            name, begun_s, _used_s = self.model[token]
            assert self.sessions.find(token, ADDRESS).name == name
            self.model[token] = (name, begun_s, self.clock.time_s)

    @rule(time_s=st.sampled_from([1.0, IDLE_S / 2.0, IDLE_S - 1.0, IDLE_S, LONGEST_S / 3.0]))
    def wait(self, time_s: float) -> None:
        self.clock.time_s += time_s
        now_s = self.clock.time_s
        for token, (_name, begun_s, used_s) in list(self.model.items()):
            if now_s - used_s >= IDLE_S or now_s - begun_s >= LONGEST_S:
                self._drop([token])

    @invariant()
    def exactly_those_are_in(self) -> None:
        for token in self.model:
            self.sessions._check(token)
        for token in self.ended:
            with pytest.raises(NotLoggedInError):
                self.sessions._check(token)

    def _of(self, name: str) -> List[str]:
        return [one for one, (own, *_times) in self.model.items() if own == name]

    def _drop(self, tokens: List[str]) -> None:
        for token in tokens:
            del self.model[token]
            self.ended.append(token)


TestRandomSessions = SessionMachine.TestCase

"""Noticing that the other end of a connection is there no more."""

import socket
import time

import pytest
from vanishing_peer import come_back, vanish

from gpr20_common.low.links import keep_alive, silence_s

LIMIT_S = 30.0


@pytest.fixture
def ends():
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname())
        theirs, _ = server.accept()
    with ours, theirs:
        yield ours, theirs


def wait_until(condition):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition never held"
        time.sleep(0.01)


def test_an_end_that_is_there_answers_each_probe_though_it_sends_nothing(ends):
    ours, _theirs = ends
    keep_alive(ours)
    for _probe in range(2):
        wait_until(lambda: silence_s(ours) > 0.5)
        wait_until(lambda: silence_s(ours) < 0.5)


@pytest.mark.needs("socket filters")
def test_an_end_that_vanishes_without_a_word_is_silent_and_found_alive_when_it_comes_back(ends):
    ours, theirs = ends
    keep_alive(ours)
    vanish(theirs)
    # Two probes remain unanswered.
    wait_until(lambda: silence_s(ours) > 2.2)
    come_back(theirs)
    wait_until(lambda: silence_s(ours) < 0.5)
    theirs.sendall(b"alive")
    assert ours.recv(5) == b"alive"

"""Random bytes at the parser and at the socket: nothing breaks, hangs or grows.

A failing draw is repeated with its seed, which the failure names.
"""

from __future__ import annotations

import os
import random
import time

import pytest
from case_kit import each_case
from rpc_wire import RawClient, wait_until, words
from socket_rig import Rig
from vna_bench import Bench
from vxi11_wire import CORE, CoreLink

from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer.scpi import MOST_COMMANDS, ScpiError, split_message
from gpr20_simulator.mid.analyzer.vna_commands import SETTINGS

DRAWS = int(os.environ.get("GPR20_RANDOM_INPUT_DRAWS", "30"))
HEADERS = [one.header.pattern.translate(str.maketrans("#", "1", "[]")) for one in SETTINGS]
PIECES = [
    *(one.encode() for one in HEADERS),
    b":CALC1:DATA? SDAT",
    b":INIT:IMM",
    b":INIT:CONT ",
    b":STAT:OPER?",
    b"?",
    b";",
    b" ",
    b"\n",
    b'"',
    b"1E999",
    b"-0.",
    b"600MHZ",
    b"9" * 500,
    b"\x00\xff\xb5",
]
# A linear parser takes milliseconds; the quadratic one took half a minute.
LIMIT_S = 2.0


def random_message(draw):
    """Return bytes that are partly commands."""
    pieces = [
        draw.choice(PIECES)
        if draw.random() < 0.7
        else bytes(draw.randrange(256) for _ in range(draw.randrange(20)))
        for _ in range(draw.randrange(1, 12))
    ]
    message = b"".join(pieces)
    # A reset takes the instrument off the network, which is what it must do.
    return message.replace(b"*", b"")


@pytest.fixture(scope="module")
def fuzzed_bench():
    one = Bench()
    yield one
    one.stop()


@pytest.fixture(scope="module")
def fuzzed_rig():
    one = Rig()
    yield one
    one.stop()


@each_case("text", ["1" * 40_000 + "X", "1" * 65, "1E" + "0" * 64, "." * 40_000])
@each_case("read", [scpi.number_between, scpi.frequency_between])
def test_numbers_of_many_characters_are_refused_at_once(read, text):
    started_s = time.process_time()
    with pytest.raises(ScpiError):
        read(text, 0.0, 1e300)
    assert time.process_time() - started_s < LIMIT_S


@each_case("command", [":FREQ:STAR ", ":SWE:POIN ", ":INIT:CONT ", ":TRAC:PRE? "])
@each_case("letter", ["1", "A", " ", "?", ":", '"', "\n"])
def test_long_arguments_are_read_in_linear_time(fuzzed_bench, command, letter):
    started_s = time.process_time()
    fuzzed_bench.send(command + letter * 150_000 + "X")
    assert time.process_time() - started_s < LIMIT_S


def test_number_of_commands_in_a_message_is_bounded():
    assert len(split_message(b":INIT;" * 10 * MOST_COMMANDS)) == MOST_COMMANDS


def serve(rig, port):
    with CoreLink(port) as link:
        assert link.write(b"*IDN?\n")[0] == 0
        assert link.read()[2].startswith(b'"Anritsu')


@each_case("seed", range(DRAWS))
def test_random_writes_leave_the_socket_working(fuzzed_rig, seed):
    draw = random.Random(seed)
    port = fuzzed_rig.vna.server.port
    with CoreLink(port) as link:
        for _ in range(10):
            error, _size = link.write(random_message(draw), flags=draw.choice((0, 8, 8, 255)))
            assert error in (0, 5, 9)
            if draw.random() < 0.5:
                link.read(size=draw.randrange(4000), io_timeout_ms=0)
    serve(fuzzed_rig, port)


@each_case("seed", range(DRAWS))
def test_random_calls_leave_the_socket_working(fuzzed_rig, seed):
    draw = random.Random(seed)
    port = fuzzed_rig.vna.server.port
    with RawClient(port) as client:
        junk = bytes(draw.randrange(256) for _ in range(draw.randrange(200)))
        if draw.random() < 0.3:
            client.send(junk)
        else:
            call = words(7, 0, 2, CORE, 1, draw.randrange(30), 0, 0, 0, 0)
            length = len(call) + draw.choice((len(junk), 0, 1 << 30))
            client.send(words(length | 0x80000000 if draw.random() < 0.9 else length) + call + junk)
    serve(fuzzed_rig, port)
    wait_until(lambda: fuzzed_rig.vna.server.link_count == 1, "freeing of the links")

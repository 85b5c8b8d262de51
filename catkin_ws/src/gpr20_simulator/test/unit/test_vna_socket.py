"""The whole analyzer and its server with the clients that people use, on a real socket."""

from __future__ import annotations

import random
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import pyvisa
import vxi11
from case_kit import each_case
from run_seed import draws
from vna_bench import Rig, connected
from vxi11_wire import CORE, CoreLink, EchoDevice, RawClient, wait_until, words

from gpr20_common.errors import InvalidValueError
from gpr20_simulator.errors import MediumError
from gpr20_simulator.low import scaled_clock
from gpr20_simulator.low.vxi11_core import Limits
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, medium_by_name
from gpr20_simulator.mid.analyzer.vna_commands import SETTINGS
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import PositionProbe
from gpr20_simulator.mid.world.scene import Scene

RESOURCE = "TCPIP::127.0.0.1{}::inst0::INSTR"


@pytest.fixture
def rig():
    one = Rig()
    yield one
    one.stop()


@pytest.fixture
def device():
    return EchoDevice()


@pytest.fixture(params=[1024, 65536])
def server(device, request):
    one = Vxi11Server(device, limits=Limits(receive_size=request.param))
    one.start()
    yield one
    one.stop()


@pytest.fixture
def visa():
    """Opens resources of PyVISA that are closed in the end."""
    manager = pyvisa.ResourceManager("@py")

    def resource(port=None):
        one = manager.open_resource(RESOURCE.format("" if port is None else f",{port}"))
        one.timeout = 30_000
        return one

    yield resource
    manager.close()


def test_pyvisa_reads_a_trace(rig, visa):
    resource = visa(rig.vna.server.port)
    assert resource.query("*IDN?").startswith('"Anritsu,MS2026C/2,SIMULATED')
    values = resource.query_binary_values(":CALC1:DATA? SDAT", container=np.array)
    assert len(values) == 2 * 101


def test_link_is_gone_until_the_fault_ends(rig):
    rig.vna.faults.set("LINK_GONE")
    # Also for those who say nothing.
    assert rig.client.client.sock.recv(1) == b""
    with pytest.raises((EOFError, OSError)):
        CoreLink(rig.vna.server.port)
    with RawClient(rig.vna.server.port) as client:
        assert client.is_closed()
    rig.vna.faults.clear()
    rig.client.link = None
    rig.client = rig.connected()
    assert rig.client.ask("*IDN?").startswith('"Anritsu')


def test_stopped_analyzer_leaves_no_thread():
    before = set(threading.enumerate())
    Rig().stop()
    wait_until(lambda: set(threading.enumerate()) <= before, "end of all threads")


def test_options_and_media_out_of_range_are_refused():
    for options in ({"seconds_per_point": -1.0}, {"seconds_per_point": np.nan}, {"port": 70000}):
        with pytest.raises(InvalidValueError, match=next(iter(options))):
            AnalyzerOptions(**options)
    assert isinstance(medium_by_name("scene", Scene()), Ground)
    assert isinstance(medium_by_name("position_probe", Scene()), PositionProbe)
    with pytest.raises(MediumError, match="position_probe"):
        medium_by_name("air", Scene())


def test_scaled_clock_goes_as_much_faster(monkeypatch):
    slept_s = []
    real = SimpleNamespace(monotonic=lambda: 100.0, sleep=slept_s.append)
    monkeypatch.setattr(scaled_clock, "time", real)
    clock = scaled_clock.ScaledClock(20.0)
    assert clock.now_s() == 2000.0
    clock.sleep_until_s(2040.0)
    assert slept_s == pytest.approx([2.0])


@each_case("length", [1, 1023, 1024, 1025, 65537, 200_001])
def test_clients_move_any_length_both_ways(server, device, visa, length):
    message = b"?" * length
    instrument = connected(server.port)
    assert instrument.ask_raw(message) == message
    assert device.messages.pop() == message and device.messages == []
    instrument.close()
    resource = visa(server.port)
    resource.write_raw(message)
    assert resource.read_raw() == message
    resource.close()
    device.messages.clear()


def test_python_vxi11_clears_locks_aborts_and_closes(device):
    server = Vxi11Server(device, portmapper_port=0)
    server.start()
    instrument = connected(server.port)
    instrument.write("old?")
    assert instrument.read_stb() == 0x10
    instrument.clear()
    assert instrument.read_stb() == 0
    instrument.lock()
    instrument.unlock()
    with pytest.raises(vxi11.vxi11.Vxi11Exception, match="8"):
        instrument.trigger()
    instrument.abort()
    instrument.abort_client.sock.close()
    instrument.close()
    assert server.link_count == 0
    server.stop()


# Random bytes.

PIECES = [one.header.pattern.translate(str.maketrans("#", "1", "[]")).encode() for one in SETTINGS]
PIECES += [b":CALC1:DATA? SDAT", b":INIT:IMM", b":INIT:CONT ", b"?", b";", b" ", b"\n", b'"']
PIECES += [b"1E999", b"600MHZ", b"9" * 500, b"\x00\xff\xb5"]


def random_message(draw):
    """Return bytes that are partly commands."""
    pieces = [
        draw.choice(PIECES) if draw.random() < 0.7 else random_bytes(draw, 20)
        for _ in range(draw.randrange(1, 12))
    ]
    # A reset takes the instrument off the network, which is what it must do.
    return b"".join(pieces).replace(b"*", b"")


def random_bytes(draw, most):
    return bytes(draw.randrange(256) for _ in range(draw.randrange(most)))


def test_random_writes_and_calls_leave_the_socket_working(rig):
    port = rig.vna.server.port
    for seed in range(draws(8)):
        draw = random.Random(seed)
        with CoreLink(port) as link:
            for _ in range(10):
                error, _size = link.write(random_message(draw), flags=draw.choice((0, 8, 8, 255)))
                assert error in (0, 5, 9), seed
                if draw.random() < 0.5:
                    link.read(size=draw.randrange(4000), io_timeout_ms=0)
        with RawClient(port) as client:
            junk = random_bytes(draw, 200)
            head = words(7, 0, 2, CORE, 1, draw.randrange(30), 0, 0, 0, 0)
            length = len(head) + draw.choice((len(junk), 0, 1 << 30))
            last = 0x80000000 if draw.random() < 0.9 else 0
            client.send(junk if draw.random() < 0.3 else words(length | last) + head + junk)
        with CoreLink(port) as link:
            assert link.write(b"*IDN?\n")[0] == 0
            assert link.read()[2].startswith(b'"Anritsu'), seed
    wait_until(lambda: rig.vna.server.link_count == 1, "freeing of the links")

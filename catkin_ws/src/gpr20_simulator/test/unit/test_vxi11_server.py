"""The server call by call, and the whole analyzer with the clients that people use."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import pyvisa
import vxi11
from case_kit import each_case
from vna_bench import Carriage
from vxi11_wire import (
    ABORT,
    CORE,
    END_REASON,
    REQUEST_COUNT,
    WAIT_LOCK,
    CoreLink,
    EchoDevice,
    RawClient,
    call,
    record,
    unpack_words,
    wait_until,
    words,
)

from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_simulator.errors import MediumError
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault
from gpr20_simulator.low.vxi11_core import Limits
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import PositionProbe
from gpr20_simulator.mid.world.scene import Scene

LIMITS = Limits(receive_size=1024, reply_size=2000, message_size=5000, links=3, connections=8)
# Of a wait that nobody ends [ms].
LONG_MS = 3_600_000


@pytest.fixture
def device():
    return EchoDevice()


@pytest.fixture
def server(device):
    one = Vxi11Server(device, limits=LIMITS)
    one.start()
    yield one
    one.stop()


@pytest.fixture
def link(server):
    with CoreLink(server.port) as one:
        yield one


def test_link_tells_receive_size_and_abort_port(server, link):
    assert (link.error, link.receive_size) == (0, 1024)
    with RawClient(link.abort_port) as abort:
        assert abort.result(ABORT, 1, 0) == b""
    with CoreLink(server.port, name=b"gpib0,5") as other:
        assert other.error == 3
    assert server.link_count == 1
    with pytest.raises(InvalidValueError, match="1024"):
        Limits(receive_size=1023)


def test_message_is_executed_at_its_end_only(device, link):
    assert link.write(b"*IDN", flags=0) == (0, 4)
    assert link.write(b"", flags=0) == (0, 0)
    assert device.messages == []
    assert link.write(b"?\n") == (0, 2)
    assert device.messages == [b"*IDN?\n"]


def test_read_in_pieces_says_why_each_piece_ended(link):
    link.write(b"abc\ndef?")
    assert link.read(size=0) == (0, REQUEST_COUNT, b"")
    assert link.read(size=6) == (0, REQUEST_COUNT, b"abc\nde")
    assert link.read(size=2) == (0, REQUEST_COUNT | END_REASON, b"f?")
    link.write(b"?" * 1000, flags=0)
    link.write(b"?" * 1001)
    # Above the size of a reply: no reason in between.
    assert link.read(size=10000) == (0, 0, b"?" * 2000)
    assert link.read(size=10000) == (0, END_REASON, b"?")


def test_clear_forgets_answers_half_messages_and_late_answers(device, link):
    device.fault = NetworkFault.ANSWER_LATE
    link.write(b"late?")
    device.fault = NetworkFault.NONE
    link.write(b"old?")
    link.write(b"half", flags=0)
    assert link.generic(15) == (0,) and device.clears == 1
    assert link.read(io_timeout_ms=10)[0] == 15
    link.write(b"new?")
    assert link.read()[2] == b"new?"
    assert device.messages[-1] == b"new?"


def test_clear_may_be_unsupported_or_missing(device, link):
    device.clear_support = ClearSupport.ERROR_8
    link.write(b"old?")
    assert link.generic(15) == (8,)
    assert link.read()[2] == b"old?"
    device.clear_support = ClearSupport.NO_PROCEDURE
    link.send(record(call(CORE, 1, 15, words(link.link, 0, 0, 0))))
    # Accepted, without verifier, PROC_UNAVAIL.
    assert unpack_words(link.reply()) == [7, 1, 0, 0, 0, 3]
    assert link.write(b"x")[0] == 0


def test_client_that_leaves_frees_its_link_and_its_lock(server, link):
    with CoreLink(server.port, lock=1) as other:
        assert link.write(b"x")[0] == 11
        # Also while it waits.
        arguments = words(other.link, 10, LONG_MS, 0, 0, 0)
        other.send(record(call(CORE, 1, 12, arguments)))
    wait_until(lambda: server.link_count == 1, "freeing of the link")
    assert link.write(b"x")[0] == 0


def test_lock_keeps_others_out_until_it_is_given_back(server, link):
    with CoreLink(server.port) as other:
        assert link.lock() == 0
        assert link.lock() == other.lock() == 11
        assert other.write(b"?")[0] == other.read()[0] == 11
        assert other.generic(13)[0] == other.generic(15)[0] == 11
        assert other.write(b"x", 8 | WAIT_LOCK, lock_timeout_ms=30)[0] == 11
        with CoreLink(server.port, lock=1, lock_timeout_ms=30) as third:
            assert third.error == 11
        assert other.unlock() == 12
        assert link.write(b"?")[0] == 0
        assert (link.unlock(), link.unlock()) == (0, 12)
        assert other.lock() == 0


def test_device_that_goes_silent_is_found_nowhere(device):
    server = Vxi11Server(device, portmapper_port=0)
    server.start()
    device.fault = NetworkFault.GO_SILENT
    with CoreLink(server.port) as link:
        with pytest.raises((EOFError, ConnectionError)):
            link.write(b"*RST")
        for port in (server.port, link.abort_port, server.portmapper_port):
            with pytest.raises(ConnectionRefusedError):
                RawClient(port)
    server.stop()


# The clients that people use.


@pytest.fixture
def visa():
    """Opens resources of PyVISA that are closed in the end."""
    manager = pyvisa.ResourceManager("@py")

    def resource(port):
        one = manager.open_resource(f"TCPIP::127.0.0.1,{port}::inst0::INSTR")
        one.timeout = 30_000
        return one

    yield resource
    manager.close()


@each_case("length", [1, 1024, 1025, 200_001])
def test_clients_move_any_length_both_ways(device, visa, length):
    server = Vxi11Server(device, limits=Limits(receive_size=1024), portmapper_port=0)
    server.start()
    message = b"?" * length
    instrument = vxi11.Instrument("127.0.0.1")
    instrument.client = vxi11.vxi11.CoreClient("127.0.0.1", server.port)
    assert instrument.ask_raw(message) == message
    instrument.close()
    resource = visa(server.port)
    resource.write_raw(message)
    assert resource.read_raw() == message
    assert device.messages[-2:] == [message] * 2
    resource.close()
    server.stop()


def test_the_whole_analyzer_is_reached_until_its_link_is_gone_and_leaves_no_thread(visa):
    before = set(threading.enumerate())
    vna = SimulatedAnalyzer(
        PositionProbe(), Carriage().position, Clock(), InstrumentScene(), AnalyzerOptions()
    )
    vna.start()
    port = vna.server.port
    resource = visa(port)
    assert resource.query("*IDN?").startswith('"Anritsu,MS2026C/2,SIMULATED')
    resource.write(":SWE:POIN 101;:FORM REAL,32")
    values = resource.query_binary_values(":CALC1:DATA? SDAT", container=np.array)
    assert len(values) == 2 * 101
    resource.close()
    with CoreLink(port) as link:
        vna.faults.set("LINK_GONE")
        # Also for those who say nothing.
        assert link.is_closed()
    with pytest.raises((EOFError, OSError)):
        CoreLink(port)
    vna.faults.clear()
    with CoreLink(port) as link:
        assert link.write(b"*IDN?")[0] == 0 and link.read()[2].startswith(b'"Anritsu')
    vna.stop()
    wait_until(lambda: set(threading.enumerate()) <= before, "end of all threads")


def test_options_and_media_out_of_range_are_refused():
    for options in ({"seconds_per_point": -1.0}, {"seconds_per_point": np.nan}, {"port": 70000}):
        with pytest.raises(InvalidValueError, match=next(iter(options))):
            AnalyzerOptions(**options)
    assert isinstance(medium_by_name("scene", Scene()), Ground)
    assert isinstance(medium_by_name("position_probe", Scene()), PositionProbe)
    with pytest.raises(MediumError, match="position_probe"):
        medium_by_name("air", Scene())

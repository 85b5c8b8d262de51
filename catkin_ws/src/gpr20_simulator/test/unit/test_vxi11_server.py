"""The socket of the analyzer, with the clients that people use."""

from __future__ import annotations

import socket
import threading

import pytest
import pyvisa
import vxi11
from case_kit import each_case
from fault_kit import raises_fault
from vxi11 import rpc
from wait_kit import wait_until

from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.low.clock import Clock
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome
from gpr20_simulator.low.vxi11_server import HOST, ListenError, Vxi11Server
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import InstrumentScene, Scene

SOCKET_LIMIT_S = 0.1


class EchoDevice:
    """Answers whatever contains a question mark with itself."""

    def __init__(self):
        self.messages, self.remote = [], None
        self.fault, self.support = NetworkFault.NONE, ClearSupport.FULL

    def is_reachable(self):
        return True

    def opened(self):
        return NetworkFault.NONE

    def execute(self, message):
        self.messages.append(message)
        return Outcome(message if b"?" in message else b"", self.fault)

    def clear(self):
        return self.support

    def set_remote(self, remote):
        self.remote = remote


@pytest.fixture
def device():
    return EchoDevice()


@pytest.fixture
def server(device):
    one = Vxi11Server(device, portmapper_port=0)
    one.start()
    yield one
    one.stop()


class Instrument(vxi11.Instrument):
    """That of the library without its destructor, which would use a dead link."""

    def __del__(self):
        pass


def linked(port, name="inst0"):
    """Return a link of python-vxi11."""
    instrument = Instrument(HOST, name)
    instrument.client = vxi11.vxi11.CoreClient(HOST, port)
    instrument.timeout = 30.0
    instrument.open()
    return instrument


@pytest.fixture
def link(server):
    one = linked(server.port)
    yield one
    one.client.close()


@pytest.fixture
def visa():
    """Opens resources of PyVISA that are closed in the end."""
    manager = pyvisa.ResourceManager("@py")

    def resource(port):
        one = manager.open_resource(f"TCPIP::{HOST},{port}::inst0::INSTR")
        one.timeout = 30_000
        return one

    yield resource
    manager.close()


@each_case("length", [1, 1024, 65537, 200_001])
def test_clients_move_any_length_both_ways(device, server, link, visa, length):
    message = b"?" * length
    assert link.ask_raw(message) == message
    # In pieces of less than an answer.
    link.write_raw(message)
    assert link.read_raw(length) == message
    resource = visa(server.port)
    resource.write_raw(message)
    assert resource.read_raw() == message
    assert device.messages[-3:] == [message] * 3
    resource.clear()
    resource.close()
    wait_until(lambda: server.link_count == 1)


def error_of(call, *arguments):
    with pytest.raises(vxi11.vxi11.Vxi11Exception) as found:
        call(*arguments)
    return found.value.err


def test_an_answer_that_does_not_come_ends_by_the_time_limit_of_the_client(link):
    link.timeout = 0.05
    assert error_of(link.read_raw) == vxi11.vxi11.ERR_IO_TIMEOUT
    link.timeout = 30.0
    link.write("old?")
    link.write("new?")
    assert (link.read(), link.read()) == ("old?", "new?")


def test_clear_empties_the_link_unless_it_is_unsupported_or_missing(device, link):
    link.write("old?")
    device.support = ClearSupport.ERROR_8
    assert error_of(link.clear) == vxi11.vxi11.ERR_OPERATION_NOT_SUPPORTED
    device.support = ClearSupport.NO_PROCEDURE
    with pytest.raises(rpc.RPCUnpackError, match="PROC_UNAVAIL"):
        link.clear()
    assert link.read() == "old?"
    device.fault = NetworkFault.ANSWER_LATE
    link.write("late?")
    device.fault, device.support = NetworkFault.NONE, ClearSupport.FULL
    # A late answer comes with the next message, in front of its own.
    assert (link.ask("new?"), link.read()) == ("late?", "new?")
    link.write("old?")
    link.clear()
    assert link.ask("new?") == "new?"
    link.remote()
    assert device.remote is True
    link.local()
    assert device.remote is False


def test_lock_keeps_others_out_until_its_link_ends(server, link):
    other = linked(server.port)
    link.lock()
    locked = vxi11.vxi11.ERR_DEVICE_LOCKED_BY_ANOTHER_LINK
    assert [error_of(one) for one in (link.lock, other.lock, other.unlock)] == [locked] * 3
    assert error_of(other.write, "x") == locked
    link.unlock()
    link.lock()
    link.client.close()
    wait_until(lambda: server.link_count == 1)
    other.lock()
    other.unlock()
    assert error_of(other.unlock) == vxi11.vxi11.ERR_NO_LOCK_HELD_BY_THIS_LINK
    other.client.close()


@each_case("data", [b"\xff\xff\xff\xff", b"\x80\x00\x00\x04abcd", b"\x80\x00\x00\x00" * 9])
def test_what_is_no_call_ends_its_connection_alone(link, server, data):
    with socket.create_connection((HOST, server.port), timeout=30.0) as bad:
        bad.sendall(data)
        assert bad.recv(1) == b""
    assert link.ask("still there?") == "still there?"


def test_silent_clients_keep_their_connections_in_a_process_of_rospy(device):
    # Every new socket gets a time limit, as rospy does it to its process.
    socket.setdefaulttimeout(SOCKET_LIMIT_S)
    try:
        server = Vxi11Server(device)
        server.start()
        link = linked(server.port)
        link.timeout = 3 * SOCKET_LIMIT_S
        link.client.sock.settimeout(30.0)
        assert error_of(link.read_raw) == vxi11.vxi11.ERR_IO_TIMEOUT
        link.timeout = 30.0
        assert link.ask("still there?") == "still there?"
        link.client.close()
        server.stop()
    finally:
        socket.setdefaulttimeout(None)


def test_portmapper_tells_the_port(server, monkeypatch):
    monkeypatch.setattr(rpc, "PMAP_PORT", server.portmapper_port)
    client = rpc.TCPPortMapperClient(HOST)
    core = vxi11.vxi11.DEVICE_CORE_PROG, vxi11.vxi11.DEVICE_CORE_VERS
    assert client.get_port((*core, rpc.IPPROTO_TCP, 0)) == server.port
    assert client.get_port((*core, rpc.IPPROTO_UDP, 0)) == 0
    client.close()
    with raises_fault(OTHER_LAUNCH, server.port, error=ListenError):
        Vxi11Server(EchoDevice(), server.port)


def test_the_whole_analyzer_is_reached_until_its_link_is_gone_and_leaves_no_thread(visa):
    before = set(threading.enumerate())
    here = AntennaPosition(0.0, 0.0, 0.0)
    medium = medium_by_name("position_probe", Scene())
    vna = SimulatedAnalyzer(medium, lambda: here, Clock(), InstrumentScene(), AnalyzerOptions())
    vna.start()
    port = vna.server.port
    resource = visa(port)
    assert resource.query("*IDN?").startswith('"Anritsu,MS2026C/2,SIMULATED')
    resource.write(":SWE:POIN 101;:FORM REAL,32")
    assert len(resource.query_binary_values(":CALC1:DATA? SDAT")) == 2 * 101
    resource.close()
    link = linked(port)
    vna.faults.set("LINK_GONE")
    # Also for those who say nothing.
    assert link.client.sock.recv(1) == b""
    with pytest.raises((EOFError, OSError)):
        linked(port)
    vna.faults.clear()
    link = linked(port)
    assert link.ask("*IDN?").startswith('"Anritsu')
    vna.stop()
    wait_until(lambda: set(threading.enumerate()) <= before)

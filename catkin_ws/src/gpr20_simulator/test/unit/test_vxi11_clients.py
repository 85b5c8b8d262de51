"""The clients that people use, on a real socket."""

from __future__ import annotations

import pytest
import pyvisa
import vxi11
from case_kit import each_case
from vxi11_wire import EchoDevice

from gpr20_simulator.low.rpc_server import ListenError
from gpr20_simulator.low.vxi11_core import Limits
from gpr20_simulator.low.vxi11_server import Vxi11Server


@pytest.fixture
def device():
    return EchoDevice()


@pytest.fixture(params=[1024, 65536])
def server(device, request):
    one = Vxi11Server(device, limits=Limits(receive_size=request.param))
    one.start()
    yield one
    one.stop()


def python_vxi11(port, timeout_s=5.0):
    instrument = vxi11.Instrument("127.0.0.1")
    instrument.client = vxi11.vxi11.CoreClient("127.0.0.1", port)
    instrument.timeout = timeout_s
    return instrument


@pytest.fixture
def instrument(server):
    one = python_vxi11(server.port)
    one.open()
    yield one
    one.client.sock.close()
    one.link = None


@pytest.fixture
def visa(server):
    manager = pyvisa.ResourceManager("@py")
    resource = manager.open_resource(f"TCPIP::127.0.0.1,{server.port}::inst0::INSTR")
    resource.timeout = 5000
    yield resource
    resource.close()
    manager.close()


@each_case("length", [1, 1023, 1024, 1025, 65536, 65537, 200_001])
def test_python_vxi11_moves_any_length_both_ways(instrument, device, length):
    message = b"?" * length
    assert instrument.ask_raw(message) == message
    assert device.messages.pop() == message and device.messages == []


def test_python_vxi11_clears_locks_and_reads_the_status(instrument, server):
    instrument.write("old?")
    assert instrument.read_stb() == 0x10
    instrument.clear()
    assert instrument.read_stb() == 0
    instrument.lock()
    instrument.unlock()
    with pytest.raises(vxi11.vxi11.Vxi11Exception, match="8"):
        instrument.trigger()


def test_python_vxi11_aborts(instrument):
    instrument.abort()
    instrument.abort_client.sock.close()


def test_python_vxi11_closes_its_link(server):
    one = python_vxi11(server.port)
    one.open()
    assert server.link_count == 1
    one.close()
    assert server.link_count == 0


def test_python_vxi11_finds_the_port_by_the_portmapper(device, monkeypatch):
    server = Vxi11Server(device, portmapper_port=0)
    server.start()
    monkeypatch.setattr(vxi11.rpc, "PMAP_PORT", server.portmapper_port)
    one = vxi11.Instrument("127.0.0.1")
    assert one.ask("*IDN?") == "*IDN?"
    one.close()
    assert vxi11.list_devices("127.0.0.1", timeout=0.2) == ["127.0.0.1"]
    server.stop()


def test_clients_find_the_server_on_port_111(device):
    try:
        server = Vxi11Server(device, portmapper_port=111)
    except ListenError as error:
        pytest.skip(str(error))
    server.start()
    one = vxi11.Instrument("127.0.0.1")
    assert one.ask("*IDN?") == "*IDN?"
    one.close()
    manager = pyvisa.ResourceManager("@py")
    with manager.open_resource("TCPIP::127.0.0.1::inst0::INSTR") as resource:
        assert resource.query("*IDN?").strip() == "*IDN?"
    server.stop()


def test_pyvisa_asks_and_is_answered_whatever_terminator_it_sends(visa, device):
    for terminator in ("", "\n", "\r\n"):
        visa.write_termination = terminator
        assert visa.query("*IDN?") == "*IDN?" + terminator
    assert device.messages == [b"*IDN?", b"*IDN?\n", b"*IDN?\r\n"]


def test_pyvisa_moves_long_messages_both_ways(visa):
    message = b"?" * 100_001
    visa.write_raw(message)
    assert visa.read_raw() == message


def test_pyvisa_locks_out_another_client(visa, server):
    visa.lock_excl()
    other = python_vxi11(server.port)
    with pytest.raises(vxi11.vxi11.Vxi11Exception, match="11"):
        other.write("x")
    visa.unlock()
    other.write("x")
    other.close()

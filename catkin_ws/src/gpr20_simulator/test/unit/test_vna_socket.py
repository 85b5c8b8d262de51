"""The whole analyzer and its server with the clients that people use, on a real socket."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import pyvisa
import vxi11
from case_kit import each_case
from vna_bench import Rig, connected
from vxi11_wire import CoreLink, EchoDevice, RawClient, wait_until

from gpr20_common.errors import InvalidValueError
from gpr20_simulator.errors import MediumError
from gpr20_simulator.low.vxi11_core import Limits
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, medium_by_name
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


@pytest.fixture
def server(device):
    one = Vxi11Server(device, limits=Limits(receive_size=1024))
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


@each_case("length", [1, 1024, 1025, 200_001])
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

"""A VXI-11 server: core channel, abort channel and, if wanted, the portmapper."""

from __future__ import annotations

from typing import Optional, Tuple

from gpr20_simulator.low import vxi11_protocol as protocol
from gpr20_simulator.low.message_device import MessageDevice, NetworkFault
from gpr20_simulator.low.portmapper import Mapping, Portmapper, tcp_mapping
from gpr20_simulator.low.rpc import Caller, RpcProgram, XdrReader, pack_int
from gpr20_simulator.low.rpc_server import RpcTcpServer
from gpr20_simulator.low.vxi11_core import CoreChannel, Limits
from gpr20_simulator.low.vxi11_links import LinkBook, LinkError
from gpr20_simulator.low.vxi11_protocol import Error


class Vxi11Server:
    """Serves one device as `inst0`.

    Args:
        device: What is served.
        host: Address to listen on; nobody but this machine reaches the default.
        port: Port of the core channel; 0: any free one.
        portmapper_port: Port of an own portmapper (111 is where clients look; 0: any free
            one); None: no portmapper, clients must know the port.
        limits: What the server bears.

    Raises:
        ListenError: A port is taken or not allowed.
    """

    def __init__(
        self,
        device: MessageDevice,
        host: str = "127.0.0.1",
        port: int = 0,
        portmapper_port: Optional[int] = None,
        limits: Limits = Limits(),  # noqa: B008 - immutable
    ) -> None:
        self._links = LinkBook(limits.links)
        longest_record, most = limits.record_size, limits.connections
        reachable = device.is_reachable
        self._abort = RpcTcpServer(
            host, 0, self._abort_program(), longest_record, most, is_reachable=reachable
        )
        channel = CoreChannel(device, self._links, limits, self._abort.port, self._misbehave)
        self._core = RpcTcpServer(
            host,
            port,
            channel.program(),
            longest_record,
            most,
            self._links.destroy_all_of,
            reachable,
        )
        self._portmapper: Optional[Portmapper] = None
        if portmapper_port is not None:
            self._portmapper = Portmapper(host, self._mappings(), portmapper_port)

    @property
    def port(self) -> int:
        """TCP port of the core channel."""
        return self._core.port

    @property
    def portmapper_port(self) -> Optional[int]:
        """Port of the portmapper; None if there is none."""
        return self._portmapper.port if self._portmapper else None

    @property
    def link_count(self) -> int:
        """Number of links at the moment."""
        return len(self._links)

    def start(self) -> None:
        """Begin to serve."""
        self._abort.start()
        self._core.start()
        if self._portmapper:
            self._portmapper.start()

    def stop(self) -> None:
        """Drop every client, stop listening and wait for the threads."""
        self._core.stop()
        self._abort.stop()
        if self._portmapper:
            self._portmapper.stop()

    def drop_connections(self) -> None:
        """Close every connection."""
        self._core.drop_connections()
        self._abort.drop_connections()

    def _mappings(self) -> Tuple[Mapping, ...]:
        return (
            tcp_mapping(protocol.CORE_PROGRAM, protocol.VERSION, self._core.port),
            tcp_mapping(protocol.ABORT_PROGRAM, protocol.VERSION, self._abort.port),
        )

    def _abort_program(self) -> RpcProgram:
        return RpcProgram(
            protocol.ABORT_PROGRAM, protocol.VERSION, {protocol.DEVICE_ABORT: self._device_abort}
        )

    def _device_abort(self, arguments: XdrReader, _caller: Caller) -> bytes:
        try:
            self._links.abort(arguments.sint())
        except LinkError as error:
            return pack_int(error.code)
        return pack_int(Error.NONE)

    def _misbehave(self, fault: NetworkFault) -> None:
        """Do to the network what the device's fault does to it."""
        if fault is NetworkFault.DROP_CONNECTIONS:
            self._core.drop_connections()
        elif fault is NetworkFault.GO_SILENT:
            if self._portmapper:
                self._portmapper.close()
            self._abort.close()
            self._core.close()

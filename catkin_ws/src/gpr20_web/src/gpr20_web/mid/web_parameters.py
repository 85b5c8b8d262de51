"""The parameters of the web page."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from pathlib import Path

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded


@dataclass(frozen=True)
class WebParameters:
    """Where the web page is, and what it allows.

    Attributes:
        address: Where it listens: 127.0.0.1 for this computer alone; the address of this computer
            in the network of the browsers; or 0.0.0.0 for all its networks. IPv6 is possible, in
            quotes.
        port: TCP port.
        folder: Folder of its accounts, keys and certificate.
        session_hours: Everybody must log in again after this long [h].
    """

    address: str = "127.0.0.1"
    port: int = bounded(1024, 65535, 8443)
    folder: str = "~/.gpr20/web"
    session_hours: float = bounded(0.1, 168.0, 12.0)

    def __post_init__(self) -> None:
        try:
            ipaddress.ip_address(self.address)
        except ValueError as error:
            raise InvalidValueError(
                Message(
                    "{name} is {value}; it must be an IPv4 or IPv6 address of this computer, such "
                    "as 127.0.0.1 or ::1",
                    name="address",
                    value=repr(self.address[:64]),
                )
            ) from error
        if not (self.folder.startswith(("/", "~/")) and self.folder.isprintable()):
            raise InvalidValueError(
                Message(
                    "{name} is {value}; it must be an absolute path, such as {example}",
                    name="folder",
                    value=repr(self.folder[:200]),
                    example=WebParameters.folder,
                ),
                fault=CONFIGURATION,
            )

    @property
    def path(self) -> Path:
        """The folder, of the person or the service that runs the page."""
        return Path(self.folder).expanduser()

    def reached_at(self, host: str) -> str:
        """Return what people write into a browser.

        Args:
            host: Name of this computer: no browser finds "all its networks".
        """
        everywhere = ipaddress.ip_address(self.address).is_unspecified
        return host if everywhere else self.address

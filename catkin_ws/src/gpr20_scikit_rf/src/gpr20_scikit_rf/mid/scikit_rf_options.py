"""What analyzer.yaml says of an analyzer of scikit-rf."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.checks import MAX_ADDRESS_CHARACTERS
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters


class ScikitRfClass(enum.Enum):
    """The classes of scikit-rf that are adapted, as named below `skrf.vi.vna`."""

    PNA = "keysight.PNA"
    FIELDFOX = "keysight.FieldFox"
    ZVA = "rohde_schwarz.ZVA"
    ZNA = "rohde_schwarz.ZNA"


@dataclass(frozen=True)
class ScikitRfOptions:
    """The `analyzer_options` of an analyzer of scikit-rf.

    Attributes:
        scikit_rf_class: Which class of scikit-rf controls the instrument.
        visa_library: VISA library of PyVISA: "@py" is PyVISA-py, "@ivi" that of the instrument's
            maker.
        correction_query: A query that this instrument answers with 1 while its calibration
            corrects the data, otherwise with 0. Empty: its calibration is not reported (status 5).
    """

    scikit_rf_class: ScikitRfClass
    visa_library: str = "@py"
    correction_query: str = ""

    def __post_init__(self) -> None:
        if not self.correction_query.isascii() or "\n" in self.correction_query:
            raise InvalidValueError(
                Message(
                    "correction_query is {query}; it must be one line of ASCII characters",
                    query=repr(self.correction_query[:64]),
                ),
                fault=CONFIGURATION,
            )


def check_parameters(parameters: VnaParameters) -> None:
    """Refuse an address or an identity that no analyzer of scikit-rf has.

    Raises:
        InvalidValueError: One is of another kind of analyzer.
    """
    visa_resource_name("address", parameters.address)
    for name in ("maker", "model"):
        if getattr(parameters, name) == getattr(VnaParameters, name):
            raise InvalidValueError(
                Message(
                    "{name} is {value}, which is no analyzer of scikit-rf; it must be as in the "
                    "VNA's identification",
                    name=name,
                    value=getattr(parameters, name),
                    details="the answer to *IDN?",
                ),
                fault=CONFIGURATION,
            )


def visa_resource_name(name: Union[str, Message], address: str) -> str:
    """Return the address if it has the form of a VISA resource name, with "::" between its parts.

    Raises:
        InvalidValueError: The text is anything else.
    """
    parts = address.split("::")
    printable = address.isascii() and address.isprintable() and " " not in address
    if len(parts) < 2 or not all(parts) or not printable or len(address) > MAX_ADDRESS_CHARACTERS:
        raise InvalidValueError(
            Message(
                "{name} is '{address}'; it must be the name of a VISA resource, such as "
                "TCPIP0::192.168.1.10::inst0::INSTR, of at most {most} characters",
                name=name,
                address=address[:64],
                most=MAX_ADDRESS_CHARACTERS,
            )
        )
    return address

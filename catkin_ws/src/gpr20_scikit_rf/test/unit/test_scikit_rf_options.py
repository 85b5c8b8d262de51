"""What analyzer.yaml may say of an analyzer of scikit-rf."""

from pathlib import Path

import yaml
from case_kit import each_case
from fault_kit import raises_fault
from tutorial_code import code_blocks

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.clock import Clock
from gpr20_common.mid.records import record_from
from gpr20_scikit_rf.mid.scikit_rf_options import visa_resource_name
from gpr20_vna_acquisition.mid.foreign_analyzer import make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

README = Path(__file__).parents[2] / "README.md"
OF_README = code_blocks(README, "yaml")["analyzer.yaml"]


def made(text):
    """Return the analyzer of a configuration, as the check before a launch makes it."""
    parameters = record_from(VnaParameters, yaml.safe_load(text), "vna_acquisition")
    return make_foreign_analyzer(parameters, RequestDeadline(Clock()))


def test_the_configuration_of_the_readme_is_accepted():
    assert made(OF_README).trace_duration_s is None


@each_case(
    "former, new, fault, shown",
    [
        ("{scikit_rf_class: keysight.PNA}", "{}", faults.CONFIGURATION, "scikit_rf_class"),
        ("keysight.PNA", "nanovna.NanoVNAv2", faults.NOT_ALLOWED, "keysight.PNA, keysight.Fiel"),
        ("keysight.PNA", "keysight.PNA, port: 1", faults.CONFIGURATION, "port is unknown"),
        ("keysight.PNA", "keysight.PNA, visa_library: 1", faults.NOT_ALLOWED, "visa_library"),
        ("keysight.PNA", "keysight.PNA, correction_query: ¿", faults.CONFIGURATION, "ASCII"),
        ("TCPIP0::192.168.1.5::inst0::INSTR", "1.2.3.4", faults.NOT_ALLOWED, "::inst0::INSTR"),
        ("model: N5222A", "", faults.CONFIGURATION, "MS2026C"),
        ("maker: Agilent Technologies", "", faults.CONFIGURATION, "Anritsu"),
    ],
)
def test_what_no_such_analyzer_has_is_refused_before_a_launch(former, new, fault, shown):
    assert former in OF_README
    with raises_fault(fault, shown, error=InvalidValueError):
        made(OF_README.replace(former, new))


@each_case(
    "address",
    [
        "TCPIP0::192.168.1.5::inst0::INSTR",
        "TCPIP0::192.168.1.5::hislip0,4880::INSTR",
        "TCPIP::192.168.1.5::5025::SOCKET",
        "GPIB0::16::INSTR",
        "USB0::0x2A8D::0x5D18::MY12345678::INSTR",
        "ASRL/dev/ttyACM0::INSTR",
    ],
)
def test_names_of_visa_resources_are_accepted(address):
    assert visa_resource_name("address", address) == address


@each_case(
    "address",
    ["", "192.168.1.5", "::", "GPIB0::", "::INSTR", "A::b c", "A::\n", "A::ñ", "A::" + "b" * 126],
)
def test_other_texts_are_no_visa_resources(address):
    with raises_fault(faults.NOT_ALLOWED, address[:64], error=InvalidValueError):
        visa_resource_name("address", address)

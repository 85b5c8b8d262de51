"""What technicians do wrong, written from the sentences of their reports and not from the check.

Each mistake is found at its file and key; what a robot may have is not refused.
"""

from typing import NamedTuple, Tuple

import pytest
from case_kit import each_case
from robot_check_examples import BUILT, checked, write

from gpr20_launch.mid.templates import templates


class Case(NamedTuple):
    """One mistake: its file, its text, its key as far as that is one, and what must be said."""

    file: str
    text: str
    key: str
    shown: Tuple[str, ...]


MISTAKES = [
    # Pins.
    Case("axes", "y: {sensor_pin: 11}", "z/dir_pin", ("pin 11", "y/sensor_pin", "z/dir_pin")),
    Case("axes", "y: {dir_pin: 13}", "y/dir_pin", ("pin 13", "x/dir_pin", "y/dir_pin")),
    Case("axes", "y: {step_pin: 15}", "y/step_pin", ("pin 15", "x/step_pin", "y/step_pin")),
    Case("axes", "x: {step_pin: 13}", "x/step_pin", ("pin 13", "x/dir_pin", "x/step_pin")),
    Case("axes", "z: {enable_pin: 40}", "z/enable_pin", ("pin 40", "y/sensor_pin")),
    Case("axes", "x: {dir_pin: 23}", "", ("pin 23", "x/dir_pin", "SPI0 SCLK", "height.yaml")),
    Case("axes", "y: {sensor_pin: 24}", "", ("pin 24", "y/sensor_pin", "CE0")),
    Case("height", "spi_bus: 1", "", ("y/", "SPI1")),
    Case("height", "spi_bus: 2", "spi_bus", ("0, 1, 3, 4, 5, 6",)),
    Case("height", "spi_device: 2", "spi_device", ("2",)),
    Case("axes", "x: {dir_pin: 17}", "x/dir_pin", ("17", "3.3 V")),
    Case("axes", "x: {step_pin: 4}", "x/step_pin", ("4", "5 V")),
    Case("axes", "y: {sensor_pin: 39}", "y/sensor_pin", ("39", "ground")),
    Case("axes", "z: {step_pin: 27}", "z/step_pin", ("27", "EEPROM")),
    Case("axes", "x: {dir_pin: 41}", "x/dir_pin", ("41",)),
    Case("axes", "x: {dir_pin: GPIO27}", "x/dir_pin", ("GPIO27", "13")),
    Case(
        "axes",
        "x: {enable_pin: 18}\ny: {enable_pin: 18, enable_active: high}",
        "y/enable_pin",
        ("pin 18", "x/enable_pin", "y/enable_pin", "enable_active"),
    ),
    Case("axes", "x: {backend: pigpio}\ny: {backend: pigpio}", "y/backend", ("rpi_gpio", "x")),
    Case("axes", "x: {sensor_pin: 3, endstop_pull: down}", "x/endstop_pull", ("3", "up")),
    # Travel, steps and speed.
    Case("axes", "y: {max_coord: 80000}", "y/max_coord", ("80000 mm",)),
    Case("axes", "x: {max_coord: 0.65}", "x/max_coord", ("0.65 mm",)),
    Case("axes", "z: {max_coord: 1000}", "z/max_coord", ("1000 deg",)),
    Case("axes", "x: {step_size: 10}", "x/step_size", ("10 mm",)),
    Case("axes", "x: {step_size: 0.1, min_step: 0.00005, late_limit_s: 0.00005}", "", ("mm/s",)),
    Case("axes", "x: {min_step: 1.5}", "x/min_step", ("1.5 s",)),
    Case("axes", "x: {min_step: 0.006}", "x/min_step", ("0.006",)),
    Case("axes", "x: {type: ROT}", "x/type", ("LIN",)),
    Case("axes", "z: {type: LIN, sensor_pin: 18}", "z/type", ("ROT",)),
    # Typing errors.
    Case("axes", "x: {step_size: 0,01}", "", ("comma",)),
    Case("axes", "x:\n  step_size: 0,01", "x/step_size", ("'0,01'", "0.01")),
    Case("axes", "x:\n  dir_pin:13", "x", ("line 2", "colon")),
    Case("axes", "x:\n\tdir_pin: 13", "", ("line 2", "tab")),
    Case("axes", "x: {step_pin: '15'}", "x/step_pin", ("'15'", "quotes")),
    Case("axes", "x: {delta_step: 1e-4}", "x/delta_step", ("1.0e-4",)),
    Case("axes", "x: {max_coord: 650 mm}", "x/max_coord", ("650", "unit")),
    Case("axes", "x: {max_cord: 650}", "x/max_cord", ("max_coord",)),
    Case("axes", "x: {dir_pin: 013}", "x/dir_pin", ("013", "13")),
    Case("axes", "x: {max_coord: 10:50}", "x/max_coord", ("10:50",)),
    Case("axes", "dir_pin: 13", "dir_pin", ("x, y, z",)),
    Case("axes", "x: {dir_pin: 13, dir_pin: 15}", "", ("dir_pin", "twice")),
    Case("site", "latitude_deg: 4,6\nlongitude_deg: -74.1", "latitude_deg", ("'4,6'", "4.6")),
    Case("site", "latitude_deg: -74.1", "latitude_deg", ("longitude_deg",)),
    Case("site", "latitude_deg: 104.6\nlongitude_deg: 4.6", "", ("104.6", "90")),
    # Data, addresses, sensors.
    Case("storage", "data: surveys", "data", ("surveys", "absolute")),
    Case("storage", "data: $HOME/surveys", "data", ("$HOME/surveys",)),
    Case("storage", "data: /etc/surveys", "data", ("/etc/surveys", "system")),
    Case("storage", "data: /", "data", ("system",)),
    Case("analyzer", "address: 192.168.1.300", "address", ("192.168.1.300",)),
    Case("analyzer", "address: 192.168.1", "address", ("192.168.1",)),
    Case("analyzer", "address: 0.0.0.0", "address", ("0.0.0.0",)),
    Case("analyzer", "address: 192.168.1.255", "address", ("192.168.1.255",)),
    Case("analyzer", "address: vna.local", "address", ("vna.local",)),
    Case("sensors", "sensors: [{name: soil}]", "sensors", ("topic",)),
    Case("hight", "spi_bus: 0", "", ("hight.yaml", "height.yaml")),
]


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("GPR20_DATA", raising=False)


@each_case("case", MISTAKES)
def test_a_mistake_of_a_technician_is_found_at_its_file_and_key(tmp_path, case):
    folder = tmp_path / str(MISTAKES.index(case))
    write(folder, {case.file: case.text})
    mistakes = [one for one in checked(folder) if one.refuses]
    # Once; but on a bus of the board there are several pins of the axes.
    assert len(mistakes) == 1 or case.text == "spi_bus: 1", mistakes
    text = str(mistakes[0].message)
    assert f"{case.file}.yaml" in text and all(shown in text for shown in case.shown), text
    assert case.key in ("", mistakes[0].key), mistakes[0].key
    assert mistakes[0].message.fault_code.startswith("config.")
    assert mistakes[0].message.remedy is not None


@each_case(
    "file, text",
    [
        ("axes", "\n".join(f"{axis}: {{enable_pin: 18, enable_active: high}}" for axis in "xyz")),
        ("axes", "x: {dir_pin: 15, step_pin: 13}"),
        ("axes", "x: {dir_pin: 37}\ny: {dir_pin: 13}"),
        ("axes", "x: {endstop_active: high, endstop_pull: down}\ny: {endstop_active: high}"),
        ("height", "spi_device: 1\nreference_voltage_v: 3.31"),
        ("analyzer", "analyzer: other:Vna\naddress: GPIB0::16::INSTR"),
        ("site", "robot: GPR-20 Ñandú\nlatitude_deg: 4.6\nlongitude_deg: -74.1"),
    ],
)
def test_nothing_is_invented_for_what_a_robot_may_have(tmp_path, file, text):
    folder = tmp_path / f"{file}{len(text)}"
    write(folder, {file: text})
    assert checked(folder) == ()


def test_the_templates_are_a_correct_configuration(tmp_path):
    write(tmp_path / "robot", templates(BUILT.axes))
    assert checked(tmp_path / "robot") == ()

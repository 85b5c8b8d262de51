"""Configurations changed at random; the pinout was typed here, from the picture of the header."""

import dataclasses
import re
import tempfile
from pathlib import Path

import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from robot_check_examples import checked, write
from run_seed import draws

from gpr20_launch.mid.axis_checks import GPIO_OF_BOARD, NOT_GPIO, spi_pins
from gpr20_launch.mid.robot_files import AXES_FILE, FILES
from gpr20_survey.axes import AxisParameters

# The header as the board shows it: odd pins left, even pins right, a row a line.
HEADER = """
    3V3 5V
    GPIO2 5V
    GPIO3 GND
    GPIO4 GPIO14
    GND GPIO15
    GPIO17 GPIO18
    GPIO27 GND
    GPIO22 GPIO23
    3V3 GPIO24
    GPIO10 GND
    GPIO9 GPIO25
    GPIO11 GPIO8
    GND GPIO7
    GPIO0 GPIO1
    GPIO5 GND
    GPIO6 GPIO12
    GPIO13 GND
    GPIO19 GPIO16
    GPIO26 GPIO20
    GND GPIO21
"""
PINOUT = re.findall(r"\S+", HEADER)
SIGNALS = {number: name for number, name in enumerate(PINOUT, 1) if name.startswith("GPIO")}
# Of a bus: MISO, MOSI, SCLK; and the chip select of each device.
BUS = {0: ("GPIO9", "GPIO10", "GPIO11"), 1: ("GPIO19", "GPIO20", "GPIO21")}
SELECT = {0: ("GPIO8", "GPIO7"), 1: ("GPIO18", "GPIO17", "GPIO16")}
DEVICES = [(bus, device) for bus, selects in SELECT.items() for device in range(len(selects))]
# Drivers that wake together: their enable pin is shared.
WIRED = ["x/dir", "x/step", "x/sensor", "x/enable", "y/dir", "y/step", "y/sensor", "y/enable"]
WIRED += ["z/dir", "z/step"]


def check(files):
    """Return what is found in a folder with these files; whether it stores surveys apart."""
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder), files)
        return checked(Path(folder), part="robot")


def test_the_header_is_that_of_the_board():
    assert {number: f"GPIO{gpio}" for number, gpio in GPIO_OF_BOARD.items()} == SIGNALS
    assert {*NOT_GPIO} == {*range(1, 41)} - {*SIGNALS}
    for bus, device in DEVICES:
        lines = [SIGNALS[pin] for pin in spi_pins(bus, device).values()]
        assert lines == [*BUS[bus], SELECT[bus][device]]


@settings(max_examples=draws(75))
@given(st.lists(st.integers(-2, 44), min_size=10, max_size=10), st.sampled_from(DEVICES))
def test_every_pin_with_two_purposes_is_found_and_none_is_invented(numbers, place):
    uses = {f"{key}_pin": number for key, number in zip(WIRED, numbers)}
    axes = {axis: {} for axis in "xyz"}
    for key, number in uses.items():
        axes[key[0]][key[2:]] = number
    bus, device = place
    names = ("MISO", "MOSI", "SCLK", f"CE{device}")
    spi = {f"SPI{bus} {name}": pin for name, pin in zip(names, spi_pins(bus, device).values())}
    wanted = set()
    for pin in SIGNALS:
        own = {key for key, number in {**uses, **spi}.items() if number == pin}
        if len(own) > 1 and own != {"x/enable_pin", "y/enable_pin"}:
            wanted.add(frozenset(own))
    height = {"spi_bus": bus, "spi_device": device}
    files = {AXES_FILE: yaml.safe_dump(axes), "height.yaml": yaml.safe_dump(height)}
    mistakes = [one for one in check(files) if one.refuses]
    said = [str(one.message).partition("purposes")[2] for one in mistakes]
    assert {frozenset(USE.findall(one)) for one in said if one} == wanted
    rest = {one.key for one, text in zip(mistakes, said) if not text}
    odd = {key for key, number in uses.items() if number not in SIGNALS or number in (27, 28)}
    assert rest == odd


USE = re.compile(r"[xyz]/\w+_pin|SPI\d \w+")
KEYS = [
    *((AXES_FILE, one.name) for one in dataclasses.fields(AxisParameters)),
    *(
        (name, one.name)
        for name, sections in FILES.items()
        for kind in sections.values()
        for one in dataclasses.fields(kind)
    ),
]


@settings(max_examples=draws(10))
@given(st.sampled_from(KEYS), st.data())
def test_a_key_that_is_mistyped_is_found(where, data):
    name, key = where
    at = data.draw(st.integers(0, len(key) - 1))
    typed = key[:at] + data.draw(st.sampled_from(["", key[at] * 2, "_", "-"])) + key[at + 1 :]
    assume(typed and typed[0] not in "-_" and typed not in {one for _name, one in KEYS})
    text, wrong = f"{typed}: 1", typed
    if name == AXES_FILE:
        text, wrong = f"x: {{{text}}}", f"x/{typed}"
    (found,) = [one for one in check({name: text}) if one.refuses]
    assert (Path(found.file).name, found.key) == (name, wrong)
    assert name in str(found.message) and typed in str(found.message)


TRIED = st.sampled_from([0, -1, 3, 1e9, 0.0004, 12.5, "up", "a:B", True, None, [], {}])


@settings(max_examples=draws(30))
@given(st.dictionaries(st.sampled_from(KEYS), TRIED, min_size=1, max_size=3))
def test_no_problem_is_about_a_key_that_nobody_wrote(values):
    files = {name: {} for name, _key in values}
    for (name, key), value in values.items():
        files[name][key] = value
    if AXES_FILE in files:
        files[AXES_FILE] = {axis: files[AXES_FILE] for axis in "xz"}
    for one in check({name: yaml.safe_dump(own) for name, own in files.items()}):
        written = {key for _name, key in values} | {"", "x", "z"}
        assert re.split(r"[/\[]", one.key)[-1] in written, one.message

"""Configurations changed at random, against an oracle that shares no table with the check.

Which pins collide is computed here from a pinout that was typed here, from the picture of the
header; which key is wrong follows from the change.
"""

import dataclasses
import re
import tempfile
from pathlib import Path
from typing import Dict, FrozenSet, NamedTuple, Set

import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from robot_check_examples import checked, write
from run_seed import draws

from gpr20_launch.mid.robot_files import AXES_FILE, FILES
from gpr20_survey.axes.axis_parameters import AxisParameters

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
EEPROM = {number for number, name in SIGNALS.items() if name in ("GPIO0", "GPIO1")}
# Of a bus: MISO, MOSI, SCLK; and the chip select of each device.
BUS = {0: ("GPIO9", "GPIO10", "GPIO11"), 1: ("GPIO19", "GPIO20", "GPIO21")}
SELECT = {0: ("GPIO8", "GPIO7"), 1: ("GPIO18", "GPIO17", "GPIO16")}
NEEDED = {"x": ("dir", "step", "sensor"), "y": ("dir", "step", "sensor"), "z": ("dir", "step")}
USE = re.compile(r"[xyz]/\w+_pin|SPI\d \w+")
PIN_KEY = re.compile(r"[xyz]/\w+_pin")


class Expected(NamedTuple):
    """What is wrong with the pins of a configuration."""

    collisions: Set[FrozenSet[str]]
    no_signal: Set[str]
    driven: Set[str]


def oracle(pins: Dict[str, int], levels: Dict[str, str], bus: int, device: int) -> Expected:
    """Return what is wrong with pins by key, levels of enable pins by axis, and a SPI device."""
    lines = dict(zip(("MISO", "MOSI", "SCLK", f"CE{device}"), (*BUS[bus], SELECT[bus][device])))
    used: Dict[int, Set[str]] = {}
    for key, number in pins.items():
        if number in SIGNALS:
            used.setdefault(number, set()).add(key)
    for name, signal in lines.items():
        number = PINOUT.index(signal) + 1
        used.setdefault(number, set()).add(f"SPI{bus} {name}")
    collisions = set()
    for keys in used.values():
        enables = {levels[key[0]] for key in keys if key.endswith("enable_pin")}
        together = all(key.endswith("enable_pin") for key in keys) and len(enables) == 1
        if len(keys) > 1 and not together:
            collisions.add(frozenset(keys))
    no_signal = {key for key, number in pins.items() if number not in SIGNALS}
    return Expected(collisions, no_signal, {key for key in pins if pins[key] in EEPROM})


def check(files):
    """Return what is found in a folder with these files; whether it stores surveys apart."""
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder), files)
        return checked(Path(folder), part="robot")


free = st.sampled_from([7, 11, 12, 13, 15, 16, 18, 22, 29, 31, 32, 33, 35, 36, 37, 38, 40])
anything = st.integers(-2, 44)


@st.composite
def wirings(draw):
    """Draw pins of all axes: a valid robot with some pins changed, or any numbers."""
    keys = [f"{axis}/{name}_pin" for axis, names in NEEDED.items() for name in names]
    pins = dict(zip(keys, draw(st.lists(free, min_size=8, max_size=8, unique=True))))
    levels = {axis: draw(st.sampled_from(["low", "high"])) for axis in NEEDED}
    for axis in draw(st.sets(st.sampled_from("xyz"))):
        pins[f"{axis}/enable_pin"] = draw(st.sampled_from([22, 32, 33]) | anything)
    for key in draw(st.lists(st.sampled_from(sorted(pins)), max_size=3)):
        pins[key] = draw(st.sampled_from(sorted(set(pins.values()))) | anything)
    bus = draw(st.sampled_from([0, 0, 1]))
    return pins, levels, bus, draw(st.integers(0, len(SELECT[bus]) - 1))


@settings(max_examples=draws(75))
@given(wirings())
def test_every_pin_with_two_purposes_is_found_and_none_is_invented(wiring):
    pins, levels, bus, device = wiring
    axes: Dict[str, Dict[str, object]] = {axis: {} for axis in NEEDED}
    for key, pin in pins.items():
        axis, name = key.split("/")
        axes[axis][name] = pin
        if name == "enable_pin":
            axes[axis]["enable_active"] = levels[axis]
    height = {"spi_bus": bus, "spi_device": device}
    files = {AXES_FILE: yaml.safe_dump(axes), "height.yaml": yaml.safe_dump(height)}
    mistakes = [one for one in check(files) if one.refuses]
    expected = oracle(pins, levels, bus, device)
    found = [one for one in mistakes if "purposes" in str(one.message)]
    uses = [frozenset(USE.findall(str(one.message).partition("purposes")[2])) for one in found]
    assert set(uses) == expected.collisions and len(uses) == len(expected.collisions)
    rest = [one for one in mistakes if one not in found]
    driven = {one.key for one in rest if "EEPROM" in str(one.message)}
    assert driven == expected.driven
    assert {one.key for one in rest} - driven == expected.no_signal
    assert all(PIN_KEY.fullmatch(one.key) and one.value for one in rest)


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

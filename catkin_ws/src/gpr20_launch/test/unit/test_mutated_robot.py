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

from gpr20_launch.mid.place_checks import Use
from gpr20_launch.mid.robot_check import BuiltRobot, check_robot
from gpr20_launch.mid.robot_files import AXES_FILE, FILES, read_configuration
from gpr20_launch.mid.templates import templates
from gpr20_survey.axes.axis_parameters import AxisParameters

PACKAGES = Path(__file__).resolve().parents[3]
AXES = PACKAGES / "gpr20_launch" / "config" / "axes.yaml"
BUILT = BuiltRobot(AXES)

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
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        found = check_robot(Use(Path(folder), {}, part="robot"), BUILT)
        if not any(one.refuses for one in found):
            read_configuration(Path(folder), AXES)  # as a launch, which refuses nothing
        return found


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


@settings(max_examples=300)
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
    found = [one for one in mistakes if one.message.fault_code == "config.pin_conflict"]
    uses = [frozenset(USE.findall(" ".join(one.uses))) for one in found]
    assert set(uses) == expected.collisions and len(uses) == len(expected.collisions)
    for one, keys in zip(found, uses):
        assert all(key in str(one.message) for key in keys)
    rest = [one for one in mistakes if one not in found]
    driven = {one.key for one in rest if one.message.fault_code == "config.pin_unusable"}
    assert driven == expected.driven
    assert {one.key for one in rest} - driven == expected.no_signal
    assert all(PIN_KEY.fullmatch(one.key) and one.value and one.uses is not None for one in rest)


def written(name):
    """Return the template of a file with every key in use, as its values by line."""
    lines = []
    for line in templates(AXES)[name].splitlines():
        bare = line.strip()
        if bare.startswith("#") and not bare.startswith("# ") and bare != "#":
            lines.append(line.replace("#", "", 1))
        elif not bare.startswith("#") and bare:
            lines.append(line)
    return lines


FULL = {name: written(name) for name in (*FILES, AXES_FILE)}
KINDS = {
    one.name: str(one.type)
    for kind in (
        AxisParameters,
        *(kind for file in FILES.values() for _name, kind in file.sections),
    )
    for one in dataclasses.fields(kind)
}


@st.composite
def keys(draw):
    """Draw a file and the number of a line that has a key with a value on it."""
    name = draw(st.sampled_from(sorted(FULL)))
    numbers = [n for n, line in enumerate(FULL[name]) if not line.rstrip().endswith(":")]
    return name, draw(st.sampled_from(numbers))


def changed(name, number, line):
    return {name: "\n".join([*FULL[name][:number], line, *FULL[name][number + 1 :]])}


def place(name, number):
    """Return the key of a line as the check names it."""
    key = FULL[name][number].split(":")[0].strip()
    above = [line for line in FULL[name][:number] if not line.startswith(" ")]
    return f"{above[-1].rstrip(':')}/{key}" if FULL[name][number].startswith(" ") else key


def mistakes_in(files, name):
    found = [one for one in check(files) if one.refuses]
    assert {Path(one.file).name for one in found} <= {name}
    return found


def test_the_templates_with_every_key_in_use_are_correct():
    files = {name: "\n".join(lines) for name, lines in FULL.items()}
    assert not [one for one in check(files) if one.refuses]


@settings(max_examples=40)
@given(keys(), st.data())
def test_a_key_that_is_mistyped_is_found(where, data):
    name, number = where
    line, key = FULL[name][number], place(*where)
    bare = key.split("/")[-1]
    at = data.draw(st.integers(0, len(bare) - 1))
    typed = bare[:at] + data.draw(st.sampled_from(["", bare[at] * 2, "_", "-"])) + bare[at + 1 :]
    assume(typed and typed != bare and typed not in KINDS and typed[0] not in "-_")
    files = changed(name, number, line.replace(bare, typed, 1))
    wrong = key.replace(bare, typed) if "/" in key else typed
    (found,) = mistakes_in(files, name)
    assert found.key == wrong and name in str(found.message) and typed in str(found.message)


# Some go together, and some do not.
OF_AXIS = {
    **{"min_coord": (-100, 0, 700), "max_coord": (0.6, 600, 900), "step_size": (0.01, 0.5, 2)},
    **{"min_step": (0.0004, 0.002, 0.01), "max_step": (0.001, 0.005, 0.02), "dir_pin": (13, 16)},
    **{"late_limit_s": (0.0003, 0.001, 0.005), "sensor_pin": (7, 16, 37), "homing_backoff": (1, 9)},
}


@settings(max_examples=40)
@given(
    st.fixed_dictionaries({}, optional={key: st.sampled_from(OF_AXIS[key]) for key in OF_AXIS}),
    st.sampled_from(sorted(OF_AXIS)),
)
def test_a_misspelt_key_has_no_consequence_where_some_value_of_it_suits_the_others(own, key):
    def refused(**values):
        files = {AXES_FILE: yaml.safe_dump({"x": {**own, **values}})}
        return [one.key for one in check(files) if one.refuses]

    own.pop(key, None)
    assume(not all(refused(**{key: value}) for value in OF_AXIS[key]))
    assert refused(**{f"{key}_": OF_AXIS[key][0]}) == [f"x/{key}_"]
    assert refused(**{key: "abc"}) == [f"x/{key}"]


@settings(max_examples=40)
@given(keys(), st.sampled_from(["{a: 1}", "1,5", ".nan", "[[1]]", "8 mm", "true?"]))
def test_a_value_of_another_kind_is_found(where, value):
    name, number = where
    key = place(*where)
    bare, kind = key.split("/")[-1], KINDS[key.split("/")[-1]]
    number_wanted = "float" in kind or "int" in kind
    assume("Dict" not in kind and (number_wanted or value in ("{a: 1}", "[[1]]")))
    line = FULL[name][number]
    files = changed(name, number, line[: line.index(":")] + f": {value}")
    found = mistakes_in(files, name)
    assert any(one.key == key and bare in str(one.message) for one in found), (line, found)
    if value == "1,5":
        assert any("1.5" in str(one.message) for one in found)


@settings(max_examples=20)
@given(keys(), st.sampled_from(["twice", "bracket", "tab", "no colon"]))
def test_a_file_that_is_damaged_is_found(where, damage):
    name, number = where
    line = FULL[name][number]
    indent = line[: len(line) - len(line.lstrip())]
    damaged = {
        "twice": f"{line}\n{line}",
        "bracket": line[: line.index(":")] + ": [1, 2",
        "tab": f"\t{line}",
        "no colon": f"{indent}{line.strip().split(':')[0]}",
    }[damage]
    assert mistakes_in(changed(name, number, damaged), name)


SUFFIXES = (".bak", "~", ".swp", ".dpkg-old", ".dpkg-new", ".dpkg-dist", ".orig")


@settings(max_examples=20)
@given(
    st.sampled_from(sorted(FULL)),
    st.text("abxyz_", min_size=1, max_size=3),
    st.sampled_from(SUFFIXES),
)
def test_a_file_of_another_name_is_found_and_a_left_over_one_refuses_nothing(name, added, suffix):
    other = name.replace(".", f"{added}.", 1)
    text = "\n".join(FULL[name])
    found = {one.message.fault_code: one for one in check({other: text, name + suffix: "x: ["})}
    unknown, left = found["config.unknown_file"], found["config.left_over_file"]
    assert unknown.refuses and other in str(unknown.message)
    assert not left.refuses and name + suffix in str(left.message)

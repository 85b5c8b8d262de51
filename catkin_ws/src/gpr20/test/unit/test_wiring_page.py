"""The pins of docs/first_real_survey.md and its picture are those of the default configuration."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[5]
PAGE = (ROOT / "docs/first_real_survey.md").read_text(encoding="utf-8")
PICTURE = (ROOT / "docs/images/wiring.svg").read_text(encoding="utf-8")
AXES = yaml.safe_load((ROOT / "catkin_ws/src/gpr20_launch/config/axes.yaml").read_text())
SIGNALS = {"direction": "dir_pin", "step": "step_pin", "endstop": "sensor_pin"}


def configured_pins():
    return {
        f"{axis.upper()} {signal}": values[key]
        for axis, values in AXES.items()
        for signal, key in SIGNALS.items()
        if key in values
    }


def test_table_and_picture_have_the_pins_of_every_axis():
    rows = re.findall(r"^\| (\d+) \| ([XYZ] \w+) \|", PAGE, re.MULTILINE)
    assert {signal: int(pin) for pin, signal in rows} == configured_pins()
    assert [one for one in configured_pins().items() if ">{} {}<".format(*one) not in PICTURE] == []

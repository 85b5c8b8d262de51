"""What the height sensor and the VNA say."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

SENSORS: Tuple[str, ...] = (
    # Height.
    QT_TRANSLATE_NOOP("RobotText", "height {height} m"),
    QT_TRANSLATE_NOOP("RobotText", "no height measured yet"),
    QT_TRANSLATE_NOOP("RobotText", "the antenna height could not be measured: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "no height: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height sensor is stuck: {count} of {all} readings are {rail}, the end of the "
        "converter's scale ({reason})",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the sensor is off or unplugged"),
    QT_TRANSLATE_NOOP("RobotText", "short circuit"),
    QT_TRANSLATE_NOOP("RobotText", "the height sensor's node is being shut down"),
    QT_TRANSLATE_NOOP("RobotText", "check its plug and supply"),
    QT_TRANSLATE_NOOP("RobotText", "the height sensor reads {distance} m"),
    QT_TRANSLATE_NOOP("RobotText", "it measures from {lowest} to {highest} m"),
    QT_TRANSLATE_NOOP("RobotText", "check that it sees the ground and how high the antennas hang"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height sensor is stuck: its last {count} readings are the very same, without "
        "any noise",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "hold a hand under it: if that ends this, it works, and frozen_readings may be "
        "larger, or 0 for no such check",
    ),
    QT_TRANSLATE_NOOP("RobotText", "if not, replace it"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the height readings scatter by {spread} m (from {lowest} to {highest} m)",
    ),
    QT_TRANSLATE_NOOP("RobotText", "at most {limit} m is allowed"),
    QT_TRANSLATE_NOOP("RobotText", "check the sensor's supply and that the antennas stand still"),
    QT_TRANSLATE_NOOP("RobotText", "the SPI bus failed: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "no MCP3008 answers on the SPI bus (it gave {reply})"),
    QT_TRANSLATE_NOOP("RobotText", "check wiring and supply"),
    QT_TRANSLATE_NOOP("RobotText", "check the wiring"),
    # VNA.
    QT_TRANSLATE_NOOP("RobotText", "connected to {identity}"),
    QT_TRANSLATE_NOOP("RobotText", "not connected"),
    QT_TRANSLATE_NOOP("RobotText", "no connection to the VNA at {address}: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "check the address, the cable and that it is on"),
    QT_TRANSLATE_NOOP("RobotText", "check the VNA and its network cable"),
    QT_TRANSLATE_NOOP("RobotText", "setting up the VNA failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "reading the VNA's calibration failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's sweep failed {count} times: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's sweep was given up: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "setting up the VNA was given up: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "it takes longer than {limit} s in all"),
    QT_TRANSLATE_NOOP("RobotText", "it failed before with: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "look at the VNA's display, and switch it off and on if this goes on",
    ),
    QT_TRANSLATE_NOOP("RobotText", "{action} at {address} failed: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{action} failed: the link to {address} is closed"),
    QT_TRANSLATE_NOOP("RobotText", "no complete answer within {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "the connection was closed by the other side"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA is not connected"),
    QT_TRANSLATE_NOOP("RobotText", "call the service connection first"),
    QT_TRANSLATE_NOOP("RobotText", "no sweep is configured"),
    QT_TRANSLATE_NOOP("RobotText", "call the service freq_sweep_setup first"),
    QT_TRANSLATE_NOOP("RobotText", "the sweep of {points} points did not end within {limit} s"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "check that the instrument is in VNA mode and not operated by hand",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check that it is in VNA mode and not operated by hand"),
    QT_TRANSLATE_NOOP("RobotText", "check that nobody operates it by hand"),
    QT_TRANSLATE_NOOP("RobotText", "nobody may operate it by hand during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's number of points changed to {points} by itself"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the instrument gave the very same data as for the sweep before",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA says it is {identity}"),
    QT_TRANSLATE_NOOP("RobotText", "expected is {expected}"),
    QT_TRANSLATE_NOOP("RobotText", "check the address, or the parameters maker and model"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA at {address} is now {identity} and was {former}"),
    QT_TRANSLATE_NOOP("RobotText", "call the service connection again"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA is not calibrated"),
    QT_TRANSLATE_NOOP("RobotText", "calibrate it before going on"),
    QT_TRANSLATE_NOOP("RobotText", "calibrate it again"),
    QT_TRANSLATE_NOOP("RobotText", "the calibration is moderate: its power level was another"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the calibration is moderate: the VNA is more than 5 degrees warmer or colder than then",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the calibration is low: the VNA is more than 10 degrees warmer or colder than then",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's calibration status is {status} ({meaning})"),
    QT_TRANSLATE_NOOP("RobotText", "no calibration"),
    QT_TRANSLATE_NOOP("RobotText", "calibrated, accuracy high"),
    QT_TRANSLATE_NOOP("RobotText", "moderate, the power level was changed"),
    QT_TRANSLATE_NOOP("RobotText", "moderate, the temperature moved by more than 5 degrees"),
    QT_TRANSLATE_NOOP("RobotText", "low, the temperature moved by more than 10 degrees"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "calibrate it, or change accepted_calibrations (now {accepted})",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the VNA accepted {accepted} instead of {asked}"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA measured {setting} instead of {asked}"),
    QT_TRANSLATE_NOOP("RobotText", "nobody else may set it up during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the VNA's frequencies are no longer those of this survey"),
    QT_TRANSLATE_NOOP("RobotText", "stop it and start anew"),
    QT_TRANSLATE_NOOP("RobotText", "every number of the trace is zero"),
    QT_TRANSLATE_NOOP("RobotText", "nothing was measured"),
    QT_TRANSLATE_NOOP("RobotText", "the imaginary part of the trace is a copy of its real part"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "S21 is weak: {level} dB in the middle, expected are {limit} dB or more",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check that both antennas are connected"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "S21 is strong: up to {level} dB, expected are {limit} dB at most",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the receiver may be overloaded or the calibration be another setup's",
    ),
    QT_TRANSLATE_NOOP("RobotText", "{count} of {all} points in a row are the very same number"),
    QT_TRANSLATE_NOOP("RobotText", "check that the VNA sweeps and is not in zero span"),
    QT_TRANSLATE_NOOP("RobotText", "the sweep took {duration} s, usual are {usual} s"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "check that nobody changed the VNA's bandwidth, and its network",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the sweep was repeated {times}: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the sweep also failed with: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{missing} of {all} numbers of the instrument are not finite"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the data block is cut: {arrived} of {announced} announced bytes arrived",
    ),
)

"""What the axes say of their motion and homing."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

AXES: Tuple[str, ...] = (
    # Axes.
    QT_TRANSLATE_NOOP("RobotText", "homed"),
    QT_TRANSLATE_NOOP("RobotText", "not homed"),
    QT_TRANSLATE_NOOP("RobotText", "homing the {axis} axis failed: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis is not homed: its position is unknown"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis has lost its zero"),
    QT_TRANSLATE_NOOP("RobotText", "resume the survey to home it"),
    QT_TRANSLATE_NOOP("RobotText", "home it"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the {axis} axis did not end its move to {target} {unit} within {limit} s",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check its motor and its node"),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis did not reach {target} {unit}: {reason}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the {axis} axis stands at {coordinate} {unit} instead of {target} {unit_too}",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the {axis} axis is silent: nothing on {topic} for {limit} s"),
    QT_TRANSLATE_NOOP("RobotText", "the axes moved during the sweep at point {index}"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the axes stand at {position} instead of {planned} before the sweep at point {index}",
    ),
    QT_TRANSLATE_NOOP("RobotText", "nobody else may move them during a survey"),
    QT_TRANSLATE_NOOP("RobotText", "the axis is not homed"),
    QT_TRANSLATE_NOOP("RobotText", "home it before moving it"),
    QT_TRANSLATE_NOOP("RobotText", "the axis is busy with another motion"),
    QT_TRANSLATE_NOOP("RobotText", "it ended without a result"),
    QT_TRANSLATE_NOOP("RobotText", "homing was stopped"),
    QT_TRANSLATE_NOOP("RobotText", "the endstop says where this axis has its zero"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the zero of this axis is not known: it has no endstop, and nothing says where it "
        "stopped last",
    ),
    QT_TRANSLATE_NOOP("RobotText", "home the axis"),
    QT_TRANSLATE_NOOP("RobotText", "home the axis, and lighten the load of this computer"),
    QT_TRANSLATE_NOOP("RobotText", "turn the antennas to their mark and call the service set_zero"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop was pressed at {coordinate} {unit}, where it should be open: steps were "
        "lost or the switch is stuck",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "stopped at {coordinate} {unit}, before the target {target} {unit_too}",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "target {target} {unit} lies outside the axis, {low} to {high} {unit_too}",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "a pulse was {late} ms late near {coordinate} {unit} at a speed at which the motor "
        "can lose steps: the position is not trusted",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop was not reached within {length} {unit}: it is stuck open, unplugged, or "
        "the motor does not turn",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop is still pressed {length} {unit} away from it: it is stuck closed or "
        "the motor does not turn",
    ),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop stayed pressed for {length} {unit}: it is stuck closed, "
        "short-circuited, or the motor does not turn",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check the switch, its cable and the motor"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the endstop switched {length} {unit} from where the carriage had backed off by "
        "{backoff} {unit_too}: it does not switch at one place",
    ),
    QT_TRANSLATE_NOOP("RobotText", "check the switch and the belt"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the process that makes the pulses made no step for {limit} s and was ended",
    ),
    QT_TRANSLATE_NOOP("RobotText", "look at what else this computer does, and home the axis"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "the last motion was slowed down by {count} late edges, the latest pulse by {late} "
        "ms: this computer does too much else",
    ),
    QT_TRANSLATE_NOOP("RobotText", "pulses without real-time scheduling, refused: {refused}"),
)

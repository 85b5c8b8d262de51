"""What the window, the operating system, ROS and the simulated robot say."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QT_TRANSLATE_NOOP

SURROUNDINGS: Tuple[str, ...] = (
    # The window itself: STOP without main_control, profiles.
    QT_TRANSLATE_NOOP("RobotText", "the axes were told to stop instead"),
    QT_TRANSLATE_NOOP("RobotText", "{axis} axis: stopping"),
    QT_TRANSLATE_NOOP("RobotText", "{axis} axis does NOT answer: {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "{name} cannot be the name of a profile"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "allowed are 1 to {most} letters, digits, blanks, - and _, with a letter or digit "
        "first and no blank last",
    ),
    QT_TRANSLATE_NOOP("RobotText", "the profiles in {path} cannot be listed: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "the profile {path} cannot be read: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "the profile {path} cannot be written: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "the profile {path} cannot be deleted: {error}"),
    QT_TRANSLATE_NOOP("RobotText", "save it again"),
    QT_TRANSLATE_NOOP(
        "RobotText",
        "free space on the disk, or let the parameter `profiles` name another folder",
    ),
    QT_TRANSLATE_NOOP("RobotText", "it is not YAML: {details}"),
    QT_TRANSLATE_NOOP("RobotText", "it is larger than {most} bytes"),
    QT_TRANSLATE_NOOP("RobotText", "it is nested more than {most} levels deep"),
    QT_TRANSLATE_NOOP("RobotText", "profile {place} must be a group of values, but is {found}"),
    QT_TRANSLATE_NOOP("RobotText", "profile {place} is unknown"),
    QT_TRANSLATE_NOOP("RobotText", "known are {names}"),
    QT_TRANSLATE_NOOP("RobotText", "profile {place} is missing"),
    QT_TRANSLATE_NOOP(
        "RobotText", "profile {place} has too many digits for a number of type float"
    ),
    QT_TRANSLATE_NOOP("RobotText", "profile {place} is {found}"),
    QT_TRANSLATE_NOOP("RobotText", "it must be a number of type {kind_of}"),
    QT_TRANSLATE_NOOP("RobotText", "it must be of type {kind_of}"),
    QT_TRANSLATE_NOOP("RobotText", "it must be a list"),
    QT_TRANSLATE_NOOP("RobotText", "it must be more than zero"),
    QT_TRANSLATE_NOOP("RobotText", "it must lie between {lowest} and {highest}"),
    # The operating system and ROS within other sentences.
    QT_TRANSLATE_NOOP("RobotText", "[Errno {number}] {reason}: '{path}' -> '{other}'"),
    QT_TRANSLATE_NOOP("RobotText", "[Errno {number}] {reason}: '{path}'"),
    QT_TRANSLATE_NOOP("RobotText", "[Errno {number}] {reason}"),
    QT_TRANSLATE_NOOP("RobotText", "Permission denied"),
    QT_TRANSLATE_NOOP("RobotText", "Operation not permitted"),
    QT_TRANSLATE_NOOP("RobotText", "No space left on device"),
    QT_TRANSLATE_NOOP("RobotText", "Disk quota exceeded"),
    QT_TRANSLATE_NOOP("RobotText", "Read-only file system"),
    QT_TRANSLATE_NOOP("RobotText", "Input/output error"),
    QT_TRANSLATE_NOOP("RobotText", "File exists"),
    QT_TRANSLATE_NOOP("RobotText", "No such file or directory"),
    QT_TRANSLATE_NOOP("RobotText", "Not a directory"),
    QT_TRANSLATE_NOOP("RobotText", "Is a directory"),
    QT_TRANSLATE_NOOP("RobotText", "Connection refused"),
    QT_TRANSLATE_NOOP("RobotText", "Connection reset by peer"),
    QT_TRANSLATE_NOOP("RobotText", "Broken pipe"),
    QT_TRANSLATE_NOOP("RobotText", "No route to host"),
    QT_TRANSLATE_NOOP("RobotText", "Network is unreachable"),
    QT_TRANSLATE_NOOP("RobotText", "Connection timed out"),
    QT_TRANSLATE_NOOP("RobotText", "timed out"),
    QT_TRANSLATE_NOOP("RobotText", "timeout exceeded while waiting for service {service}"),
    QT_TRANSLATE_NOOP("RobotText", "service [{service}] unavailable"),
    QT_TRANSLATE_NOOP("RobotText", "unable to connect to service: {reason}"),
    # The simulated robot.
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED robot works"),
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED robot has faults: {faults}"),
    QT_TRANSLATE_NOOP("RobotText", "SIMULATED VNA was reset and lost its network settings"),
    # A service's name before its words.
    QT_TRANSLATE_NOOP("RobotText", "{service}: {reason}"),
)

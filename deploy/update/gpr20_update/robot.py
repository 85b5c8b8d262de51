"""The robot: whether a survey runs, its services, and what the doctor finds."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
from pathlib import Path
from typing import Collection, Dict, List, Optional, Sequence

from gpr20_update.system import Paths, UpdateError, run

USER = "gpr20"
HOME = "/var/lib/gpr20"
# In the order in which they are stopped; the window shows what the others do.
SERVICES = ("gpr20-window", "gpr20")
FIREWALL = "gpr20-firewall"
# Of gpr20_msgs/ControlStatus: checking, homing, surveying, paused, stopping, pausing.
SURVEY_CODES = frozenset({2, 3, 4, 5, 6, 10})
FAULT = "FAULT"
STOP_LIMIT_S = 300.0
STATE_LIMIT_S = 20.0
# In the language of the environment, which is English here.
DOCTOR = ("doctor", "--json")
# For nodes that start; the doctor continues as soon as each has reported.
WAIT = ("--wait", "60")
DOCTOR_LIMIT_S = 150.0
# What is wrong only while the robot starts is not found again.
LOOKS = 3
_NAMESPACE = re.compile(r"^GPR20_LAUNCH_ARGUMENTS=.*\bns:=([\w/]+)", re.MULTILINE)


class Robot:
    """The robot's software on this computer."""

    def __init__(self, paths: Paths) -> None:
        self._paths = paths

    def refuse_during_survey(self, sure: bool) -> None:
        """Refuse while a survey runs or is paused, or if that cannot be found out.

        Args:
            sure: Somebody has looked: no survey runs, although the nodes do not say so.

        Raises:
            UpdateError: A survey runs, or may run.
        """
        folder = _written_survey(self._paths.processes)
        if folder is not None:
            raise UpdateError(
                f"a survey runs or is paused: {folder} is being written; finish or stop it first"
            )
        process = _launched_by_hand(self._paths.processes)
        if process is not None:
            raise UpdateError(
                f"process {process} runs a robot that was launched by hand; end it first"
            )
        if sure or not self.active():
            return
        code = self._control_code()
        if code is None:
            raise UpdateError(
                "the main control does not say whether a survey runs or is paused; see on the "
                "window or on the robot that none is, then repeat with --no-survey"
            )
        if code in SURVEY_CODES:
            raise UpdateError("a survey runs or is paused; finish or stop it first")

    def _control_code(self) -> Optional[int]:
        settings = self._paths.settings
        text = settings.read_text("utf-8", "replace") if settings.is_file() else ""
        namespace = _NAMESPACE.search(text)
        more = {"ROS_NAMESPACE": namespace.group(1)} if namespace else {}
        asked = ("ros", "rostopic", "echo", "-n", "1", "control_status/code")
        answer = self._run_part(*asked, limit_s=STATE_LIMIT_S, **more).split()
        return int(answer[0]) if answer and answer[0].isdigit() else None

    def active(self) -> List[str]:
        """Return the services that run, or that systemd starts again and again."""
        if not (self._paths.root / "run/systemd/system").is_dir():
            return []
        units = [f"{one}.service" for one in SERVICES]
        asked = ("systemctl", "show", "--property=ActiveState", "--value", *units)
        states = run(*asked, limit_s=STATE_LIMIT_S).output.split()
        if len(states) != len(SERVICES):
            raise UpdateError("systemd does not say which services run; restart this computer")
        return [one for one, state in zip(SERVICES, states) if state not in ("inactive", "failed")]

    def stop(self) -> None:
        """Stop the services that run; return when they have ended.

        Raises:
            UpdateError: They do not end.
        """
        units = [f"{one}.service" for one in self.active()]
        if units and run("systemctl", "stop", *units, limit_s=STOP_LIMIT_S).status != 0:
            raise UpdateError(f"{', '.join(units)} cannot be stopped; restart this computer")

    def start(self, services: Sequence[str]) -> None:
        """Let systemd start services; it does so after this program if that runs at boot."""
        if not services:
            return
        run("systemctl", "--no-block", "try-restart", f"{FIREWALL}.service", limit_s=STOP_LIMIT_S)
        units = [f"{one}.service" for one in services]
        run("systemctl", "--no-block", "start", *units, limit_s=STOP_LIMIT_S)

    def faults(self) -> Optional[Dict[str, str]]:
        """Return each FAULT that the doctor finds, by check, code and number; None: it cannot."""
        asked = (*DOCTOR, *(WAIT if self.active() else ()))
        try:
            findings = json.loads(self._run_part(*asked, limit_s=DOCTOR_LIMIT_S))["findings"]
            bad = [one for one in findings if one["level"] == FAULT]
            keys = [f"{one['check']} {one['fault_code']}" for one in bad]
            # One that was there before must not hide another of the same check and code.
            numbers = [keys[:last].count(key) for last, key in enumerate(keys)]
            return {f"{key} {n}": str(one["text"]) for key, n, one in zip(keys, numbers, bad)}
        except (ValueError, KeyError, TypeError):
            return None

    def new_faults(self, known: Collection[str]) -> List[str]:
        """Return what is wrong that was not before, as sentences; empty: nothing.

        Args:
            known: What was wrong before, by check, code and number.
        """
        wrong = ["the doctor could not judge"]
        for _look in range(LOOKS):
            found = self.faults()
            if found is not None:
                wrong = sorted(text for key, text in found.items() if key not in known)
                if not wrong:
                    break
        return wrong

    def _run_part(self, *arguments: str, limit_s: float, **more: str) -> str:
        """Run a part of the robot as its user; return what it printed."""
        command = ("runuser", "-u", USER, "--", "gpr20-run", *arguments)
        return run(*command, limit_s=limit_s, more={"HOME": HOME, **more}).output


def _written_survey(processes: Path) -> Optional[str]:
    """Return the folder of a survey that a process of this computer writes, if any.

    Every writer holds the lock of the survey's folder until the survey has ended, a paused one
    too. Whatever the data folder is, and whether or not the robot's nodes answer, it is found
    here. Only root sees the files of every process.
    """
    for entry in processes.glob("[0-9]*/fd/*"):
        # Processes end and close their files meanwhile.
        with contextlib.suppress(OSError):
            if entry.is_dir() and (entry / "survey.json").is_file() and _is_locked(entry):
                return os.readlink(str(entry))
    return None


def _is_locked(folder: Path) -> bool:
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def _launched_by_hand(processes: Path) -> Optional[int]:
    """Return the number of a process that runs a robot without its services, if any."""
    for process in processes.glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (process / "cmdline").read_bytes().split(b"\0")
            if any(one.endswith(b"/roslaunch") for one in words[:2]):
                group = (process / "cgroup").read_text(encoding="utf-8", errors="replace")
                if "/gpr20" not in group:
                    return int(process.name)
    return None

"""What the window says 1, 5 and 30 s after each of twelve faults of the simulated robot.

It writes a picture for each moment, all words as JSON, and one table, `table.md`. Each fault meets
a robot of its own.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

from robot_kit import MASTER, LaunchedRobot, simulated_robot
from window_kit import Operator, run_events

from gpr20_common.high.service_client import ServiceClient
from gpr20_msgs.srv import ServiceMove, ServiceMoveRequest
from gpr20_operator.robot.condition import condition_of
from gpr20_simulator.srv import SetFault
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.window.main_window import MainWindow
from pictures.kit import Shown, save, shown_window, wait

MOMENTS_S = (1.0, 5.0, 30.0)
# Long moves at the speed of the robot, so that a fault meets an axis on its way.
SURVEY = {"x_points": 4, "x_stop_mm": 600.0, "y_points": 4, "frequency_points": 51}
# More than the reserve of the storage, which is 500 MB.
SMALL_DISK = "size=560m"
LIMIT_S = 20.0
BLOCK = b"x" * 2**16
STORAGE = "vna_processing"


@dataclass
class Scene:
    """A robot, the window that shows it, and another client.

    Attributes:
        robot: Its processes.
        window: The window.
        operator: Asks as another window would.
        undo: What is done at the end.
    """

    robot: LaunchedRobot
    window: MainWindow
    operator: Operator
    undo: List[Callable[[], None]] = field(default_factory=list)

    def set_fault(self, device: str, fault: str, count: int = 0) -> None:
        """Switch a fault of the simulator on."""
        self.operator.call("simulator/set_fault", SetFault, device=device, fault=fault, count=count)

    def kill(self, node: str) -> None:
        """Kill a node."""
        if not self.robot.kill(node):
            raise SystemExit(f"{node} is not there to be killed")

    def freeze(self, *nodes: str) -> None:
        """Halt nodes, as a computer that hangs or whose network is cut."""
        found = self.robot.processes()
        for node in nodes:
            found[node].suspend()
            self.undo.append(partial(_end, found[node]))

    def survey(self, **changes: Any) -> None:
        """Start a survey; return when it has measured."""
        self.start(**changes)
        wait(lambda: self.visited >= 2, "the survey measures")

    def start(self, **changes: Any) -> None:
        """Start a survey."""
        self.operator.start(**{**SURVEY, **changes})

    @property
    def visited(self) -> int:
        """How many traces the survey has."""
        snapshot = self.window.survey.snapshot
        known = snapshot.running and snapshot.progress is not None
        return snapshot.progress.visited_points if known and snapshot.progress else 0

    def wait_for_motion(self) -> None:
        """Return while the x axis moves."""
        wait(lambda: any(one.axis.value == "x" for one in self.window.survey.snapshot.moving), "x")

    def fill_disk(self) -> None:
        """Leave no space where the surveys are stored."""
        ballast = (self.robot.data / "ballast").open("wb", buffering=0)
        with ballast, contextlib.suppress(OSError):
            while True:
                ballast.write(BLOCK)


def _end(process: Any) -> None:
    with contextlib.suppress(Exception):  # the watchdog may have ended it
        process.send_signal(signal.SIGCONT)


def _to_a_dense_survey(scene: Scene) -> None:
    """Survey with short moves: the analyzer is always used."""
    scene.survey(x_points=21, x_stop_mm=350.0)


def _to_a_motion(scene: Scene) -> None:
    scene.survey()
    scene.wait_for_motion()


def _to_the_end(scene: Scene) -> None:
    scene.start(x_points=3, y_points=3, x_stop_mm=70.0, y_stop_mm=70.0)
    wait(lambda: scene.window.survey.snapshot.code is SurveyState.FINISHED, "the survey ends")


def _home(scene: Scene) -> None:
    call = ServiceClient("service_move", ServiceMove).call
    home = partial(call, LIMIT_S * 3, axis="x", action=ServiceMoveRequest.HOME, distance=0.0)
    threading.Thread(target=home, daemon=True).start()
    scene.wait_for_motion()


@dataclass(frozen=True)
class Fault:
    """A fault and how it is met.

    Attributes:
        title: What happens, in the table.
        prepare: Called before it.
        happen: Makes it; the moments count from its end.
        time_scale: How many times faster than in reality the robot moves.
        small_disk: Whether the surveys are on a small disk.
    """

    title: str
    happen: Callable[[Scene], None]
    prepare: Callable[[Scene], None] = Scene.survey
    time_scale: int = 4
    small_disk: bool = False


def _vna_off(scene: Scene) -> None:
    scene.set_fault("vna", "DROP")


FAULTS: Dict[str, Fault] = {
    "vna_at_start": Fault("VNA switched off, then START", Scene.start, _vna_off),
    "vna_in_survey": Fault(
        "VNA's cable pulled during a survey",
        lambda scene: scene.set_fault("vna", "HANG"),
        _to_a_dense_survey,
    ),
    "storage_killed": Fault("storage killed", lambda scene: scene.kill(STORAGE)),
    "control_killed": Fault("main control killed", lambda scene: scene.kill("main_control")),
    "control_frozen": Fault("main control frozen", lambda scene: scene.freeze("main_control")),
    "axis_killed": Fault(
        "X axis killed while it moves",
        lambda scene: scene.kill("x_axis-axis_driver"),
        _to_a_motion,
    ),
    "endstop": Fault(
        "endstop of Y never closes, then START",
        Scene.start,
        lambda scene: scene.set_fault("endstop_y", "STUCK_OPEN"),
        # Its fault is sure only after the whole length of the axis.
        time_scale=40,
    ),
    "height": Fault("height out of range", lambda scene: scene.set_fault("adc", "OUT_OF_RANGE")),
    "disk_full": Fault("disk full", Scene.fill_disk, small_disk=True),
    "master_killed": Fault("ROS master killed", lambda scene: scene.kill(MASTER)),
    "storage_cut": Fault(
        "network to the storage and imaging cut",
        lambda scene: scene.freeze(STORAGE, "imaging"),
    ),
    "stopped_by_other": Fault("STOP by another client", lambda scene: scene.operator.stop()),
    "homed_by_other": Fault("an axis homes after FINISHED", _home, _to_the_end),
}


def make(folder: Path, names: Tuple[str, ...] = ()) -> None:
    """Meet every fault, take the pictures, and write the table."""
    failed = []
    for name in names or tuple(FAULTS):
        # A process can be a ROS node, and a Qt application, only once.
        process = multiprocessing.Process(target=_meet, args=(name, folder))
        process.start()
        process.join()
        if process.exitcode:
            failed.append(name)
    lines = ["| fault | 1 s | 5 s | 30 s | first step |", "| --- | --- | --- | --- | --- |"]
    for name, fault in FAULTS.items():
        found = folder / f"{name}.json"
        if found.exists():
            lines.append(_row(fault.title, json.loads(found.read_text("utf-8"))))
    (folder / "table.md").write_text("\n".join(lines) + "\n", "utf-8")
    print(folder / "table.md")
    if failed:
        raise SystemExit(f"not met: {', '.join(failed)}")


def _row(title: str, moments: Dict[str, Dict[str, str]]) -> str:
    """Return a line of the table: level and title of each band, and the first step."""
    cells, steps = [title], [""]
    for said in moments.values():
        card = ", card" if said["card"] else ""
        cells.append(f"{said['level']} {said['title']}{card}")
        steps += [said["next"]] if said["next"] and said["level"] != "working" else []
    return f"| {' | '.join([*cells, steps[-1]])} |"


def _meet(name: str, folder: Path) -> None:
    fault = FAULTS[name]
    scale = f"time_scale:={fault.time_scale}"
    with simulated_robot(scale) as robot, contextlib.ExitStack() as end:
        if fault.small_disk:
            end.enter_context(_small_disk(robot.data))
        with shown_window(robot.data) as shown:
            scene = Scene(robot, shown.window, Operator())
            try:
                wait(lambda: _is_ready(shown.window), "the robot is ready")
                fault.prepare(scene)
                fault.happen(scene)
                said = _look(shown, name, folder)
            finally:
                for undo in scene.undo:
                    undo()
    text = json.dumps(said, indent=1, ensure_ascii=False)
    (folder / f"{name}.json").write_text(text + "\n", "utf-8")


def _is_ready(window: MainWindow) -> bool:
    snapshot = window.survey.snapshot
    known = snapshot.can_start and snapshot.robot is not None
    return known and snapshot.health.settled and snapshot.health.trouble is None


def _look(shown: Shown, name: str, folder: Path) -> Dict[str, Dict[str, str]]:
    begun_s, said = time.monotonic(), {}
    last: Dict[str, str] = {}
    for after_s in MOMENTS_S:
        while time.monotonic() < begun_s + after_s:
            run_events(0.1)
            words = _words(shown.window)
            if words != last:
                print(f"{name} {time.monotonic() - begun_s:.1f} s: {words}", flush=True)
            last = words
        said[str(after_s)] = last
        save(shown.window, folder / f"{name}_{after_s:g}s.png", drawn_s=0.05)
    return said


def _words(window: MainWindow) -> Dict[str, str]:
    shown, card = condition_of(window.survey.snapshot), window.notice
    opened = card.notice if card.isVisible() else None
    step: Optional[str] = None if shown.remedy is None else str(shown.remedy)
    if opened is not None and opened.first is not None:
        step = str(opened.first)
    return {
        "level": shown.level.value,
        "title": str(shown.title),
        "message": shown.message.sentence(),
        "card": "" if opened is None else f"{opened.title}: {opened.text.sentence()}",
        "next": step or "",
    }


@contextlib.contextmanager
def _small_disk(folder: Path) -> Iterator[None]:
    """Put a folder on a small disk; needs root."""
    folder.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", SMALL_DISK, "tmpfs", str(folder)], check=True)
    accept = ["rosrun", "gpr20_launch", "robot_config", "accept_data"]
    try:
        subprocess.run([*accept, "--data", str(folder)], check=True, timeout=LIMIT_S)
        yield
    finally:
        # Lazily: the storage may still be writing its last index.
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


if __name__ == "__main__":
    make(Path(sys.argv[1]), tuple(sys.argv[2:]))

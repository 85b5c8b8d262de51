"""The simulated robot under a ROS master of its own: start it, find and kill its processes, end it.

Beside it, what stands in for one of its nodes.

For the scripts and benchmarks that launch a whole robot; needs the ROS environment.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional
from xmlrpc.server import SimpleXMLRPCServer

import psutil

MASTER = "rosmaster"
BESIDE_MASTER = Path(__file__).resolve().parents[2] / "deploy/beside_master.py"
# roslaunch starts it last: once it is there, a signal ends the whole launch.
WATCHDOG = "watchdog"
# As roslaunch names the log files of the nodes, which stand in their command lines.
NODES = (
    "x_axis-axis_driver",
    "y_axis-axis_driver",
    "z_axis-axis_driver",
    "height_sensor",
    "vna_acquisition",
    "vna_processing",
    "imaging",
    "main_control",
    "simulator",
    "rosout",
)
# Only with web:=true.
WEB = "web"
LAUNCH = "roslaunch"
# In the environment of every process of a launch.
MARK = "GPR20_LAUNCHED_ROBOT"
START_LIMIT_S = 200.0
END_LIMIT_S = 60.0
KILLED_LIMIT_S = 0.1
PORTS_GIVEN = Path("/proc/sys/net/ipv4/ip_local_port_range")
OWN_PORTS, PORTS_OF_PROCESS = 8000, 20


class RpcServer:
    """An XML-RPC server in a thread, as a node or the master has one; `running` halts it."""

    def __init__(self, **methods: Callable[..., Any]) -> None:
        self.server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        self.uri = f"http://127.0.0.1:{self.server.server_address[1]}/"
        self.running = threading.Event()
        self.running.set()
        for name, method in methods.items():
            self.server.register_function(self._when_running(method), name)
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()

    def close(self) -> None:
        self.running.set()
        self.server.shutdown()
        self.server.server_close()

    def _when_running(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def answer(*arguments: Any) -> Any:
            self.running.wait()
            return method(*arguments)

        return answer


def free_port() -> int:
    """Return a port of loopback that is this process's own until it ends.

    Nobody is given it by chance: it is below those that the system hands out.
    """
    first_given = int(PORTS_GIVEN.read_text().split()[0])
    ports = range(first_given - OWN_PORTS, first_given)
    for number in range(len(ports)):
        port = ports[(os.getpid() * PORTS_OF_PROCESS + number) % len(ports)]
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0gpr20_port_{port}")
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", port))
        except OSError:  # somebody else's
            claim.close()
            continue
        # The system closes it with the process.
        claim.detach()
        return port
    raise RuntimeError(f"none of the ports {ports[0]} to {ports[-1]} is free")


class LaunchedRobot:
    """The processes of one launch; this process and those that it starts use its master.

    Args:
        folder: Where the log of the launch is kept, and the surveys unless `data` is given.
        arguments: Arguments of the launch file.
        launch: How roslaunch finds the launch file.
        data: The folder of the surveys.
        apart: Whether the master is started apart from roslaunch, as on an installed robot.
    """

    def __init__(
        self,
        folder: Path,
        *arguments: str,
        launch: str = "gpr20 survey.launch ui:=false",
        data: Optional[Path] = None,
        apart: bool = False,
    ) -> None:
        self._beside_master = [sys.executable, str(BESIDE_MASTER)] if apart else []
        self.data = data or folder / "data"
        self._state = folder / "state"
        self._mark = str(uuid.uuid4())
        self._log = (folder / "launch.log").open("ab")
        self._command = [*launch.split(), f"data:={self.data}", *arguments]
        self._launch: Optional[subprocess.Popen] = None

    def start(self) -> None:
        """Launch on a free port; return when every process is there.

        Raises:
            RuntimeError: The robot does not start.
        """
        port = free_port()
        os.environ.update(
            ROS_MASTER_URI=f"http://127.0.0.1:{port}",
            ROS_IP="127.0.0.1",
            GPR20_STATE=str(self._state),
        )
        command = [*self._beside_master, "roslaunch", "-p", str(port), *self._command]
        self._launch = self.run(command, {MARK: self._mark})
        deadline_s = time.monotonic() + START_LIMIT_S
        while not {*NODES, MASTER, WATCHDOG} <= set(self.processes()):
            if self._launch.poll() is not None or time.monotonic() > deadline_s:
                self.stop()
                raise RuntimeError(f"the robot does not start; see {self._log.name}")
            time.sleep(0.1)

    def run(self, command: list, environment: Optional[Dict[str, str]] = None) -> subprocess.Popen:
        """Start a process that writes into the log; a Ctrl-C in the terminal does not reach it.

        Args:
            command: The program and its arguments.
            environment: What is added to the environment.
        """
        return subprocess.Popen(
            command,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, **(environment or {})},
        )

    def client(self, *options: str, **streams: Any) -> subprocess.Popen:
        """Start the terminal client; `streams` are those of `Popen`."""
        return subprocess.Popen(
            ["rosrun", "gpr20_user_interface", "run_survey", *options], **streams
        )

    def processes(self) -> Dict[str, psutil.Process]:
        """Return the processes that run now: those of `NODES`, `MASTER`, `WATCHDOG` and `WEB`."""
        words = {name: f"/{name}-" for name in (*NODES, WATCHDOG, WEB)}
        words.update({MASTER: MASTER, "rosout": "/lib/rosout/rosout"})
        found = {}
        for child in self._children():
            with contextlib.suppress(psutil.NoSuchProcess):  # ended meanwhile
                line = " ".join(child.cmdline())
                found.update({name: child for name, word in words.items() if word in line})
        return found

    def kill(self, name: str) -> bool:
        """Kill a node, the master or roslaunch; return whether it was there to be killed."""
        process: Any = self._launch if name == LAUNCH else self.processes().get(name)
        if process is None or (name == LAUNCH and process.poll() is not None):
            return False
        process.kill()
        if name == LAUNCH:
            process.wait()
        return True

    def kill_all(self) -> None:
        """Kill every process of the launch; return when they have ended."""
        # First, so that nothing is started again meanwhile.
        self.kill(LAUNCH)
        self._launch = None
        left = self._left()
        while left:
            for process in left:
                with contextlib.suppress(psutil.NoSuchProcess):
                    process.kill()
            # Not longer: where no init collects the dead, they seem to be there for ever.
            psutil.wait_procs(left, KILLED_LIMIT_S)
            left = self._left()

    def stop(self) -> None:
        """End everything, as Ctrl-C does; also what a roslaunch that was killed has left."""
        end(self._launch, signal.SIGINT)
        self.kill_all()

    def _children(self) -> list:
        found: List[psutil.Process] = []
        with contextlib.suppress(psutil.NoSuchProcess):
            found += psutil.Process(self._launch.pid).children() if self._launch else []
        for child in tuple(found) if self._beside_master else ():
            with contextlib.suppress(psutil.NoSuchProcess):  # the master, when it was killed
                found += child.children()
        return found

    def _left(self) -> List[psutil.Process]:
        """Return the processes of the launch, whoever is their parent now."""
        found = []
        for process in psutil.process_iter():
            with contextlib.suppress(psutil.Error):  # ended meanwhile, or another user's
                if process.environ().get(MARK) == self._mark:
                    found.append(process)
        return found


def end(process: Optional[subprocess.Popen], number: signal.Signals) -> None:
    """End a process that leads a session, unless it has ended; kill the session if it does not."""
    if process is None or process.poll() is not None:
        return
    process.send_signal(number)
    try:
        process.wait(END_LIMIT_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)


@contextlib.contextmanager
def running(
    *command: str, end_by: signal.Signals = signal.SIGINT, **options: Any
) -> Iterator[subprocess.Popen]:
    """Run a process, and end it in the end; `options` are those of `Popen`."""
    process = subprocess.Popen(
        command, start_new_session=True, stdout=subprocess.DEVNULL, **options
    )
    try:
        yield process
    finally:
        end(process, end_by)


def resident_mib(pid: Optional[int] = None) -> float:
    """Return the memory that a process has in use [MiB]; None: this process."""
    return float(psutil.Process(pid).memory_info().rss) / 2**20


@contextlib.contextmanager
def simulated_robot(*arguments: str) -> Iterator[LaunchedRobot]:
    """Launch a robot with arguments of survey.launch; its folder is removed in the end."""
    with tempfile.TemporaryDirectory(prefix="gpr20_robot_") as folder:
        robot = LaunchedRobot(Path(folder), *arguments)
        try:
            robot.start()
            yield robot
        finally:
            robot.stop()

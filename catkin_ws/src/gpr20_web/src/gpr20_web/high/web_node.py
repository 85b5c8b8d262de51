"""The node web: the robot's topics and services in, browsers out."""

from __future__ import annotations

import asyncio
import os
import socket
import threading
from collections import deque
from dataclasses import asdict
from pathlib import Path
from typing import Any, Coroutine, Deque, Dict, Optional

import rospy

from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.low.clock import Clock
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.low.yaml_file import data_folder
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NO_HARDWARE
from gpr20_msgs.msg import WebStatus
from gpr20_operator.high.control_client import ControlClient, RemoteControlClient
from gpr20_operator.high.ros_events import RequestError
from gpr20_operator.high.storage_client import StorageClient
from gpr20_operator.jobs.job import Delivery, Service
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.remote_control import RemoteAllowance, WebStatusReported
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_web.faults import NotNowError
from gpr20_web.low.accounts import Accounts
from gpr20_web.low.http_server import HttpServer
from gpr20_web.low.logins import Logins
from gpr20_web.low.web_folder import ensure_certificate, ssl_context
from gpr20_web.mid.commands import Commands
from gpr20_web.mid.ground_page import GroundPage
from gpr20_web.mid.presses import AuditNotes, Lease
from gpr20_web.mid.robot_pages import NowPage, ServicePage
from gpr20_web.mid.shell import Shell
from gpr20_web.mid.surveys_page import SurveysPage
from gpr20_web.mid.web_parameters import WebParameters

NODE = "web"
STATIC = Path(__file__).resolve().parent.parent / "static"
# The window refreshes as often; nobody reads figures that change faster.
BEAT_S = 0.2
# While nobody watches.
REST_S = 1.0
# As often as the window, while somebody looks.
MASTER_CHECK_S = 2.0
# A page that is loaded again finds what is known of the axes: a STOP may wait for it.
LINGER_S = 10.0
CLOSE_LIMIT_S, CALL_LIMIT_S = 3.0, 5.0
# For the commands that are not noted yet when the node ends.
NOTES_LIMIT_S = 3.0


class WebNode:
    """Everything connected; what is shown belongs to the thread of the event loop."""

    def __init__(self, parameters: WebParameters, data: Path) -> None:
        """Connect everything, and answer browsers.

        Raises:
            WebError: There is no certificate, the port is taken, or the accounts are damaged.
        """
        self._parameters, self._clock = parameters, Clock()
        self._refreshed_s = self._checked_s = self._watched_s = -LINGER_S
        self._said: Optional[WebStatusReported] = None
        # Of any thread; one beat takes many: an axis reports 50 times a second.
        self._events: Deque[Any] = deque()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="page", daemon=True)
        folder = parameters.path
        self._certificate = ensure_certificate(folder, (parameters.address,))
        self._accounts = Accounts(folder)
        key, longest_hours = self._certificate.cookie_key, parameters.session_hours
        self._logins = Logins(self._accounts, key, longest_hours, self._clock)
        self._model = SurveyModel(self._clock)
        self._connect_clients()
        self._notes = AuditNotes(self._storage, self._clock.now_s, self._warn)
        self._lease = Lease(self._clock, lambda session: self._server.streams.has(session))
        self._commands = Commands(
            *(self._model, self._control, RemoteAllowance(self._clock)),
            *(self._clock, self._lease, self._notes.add),
        )
        self._shell = self._new_shell(data)
        self._server = HttpServer(
            *(self._shell.all_routes(), self._shell.files(STATIC)),
            *(self._logins.find, self._report),
        )
        self._status = rospy.Publisher("web_status", WebStatus, queue_size=5, latch=True)
        self._diagnostics = Diagnostics(NODE, self._health)
        self._description = publish_description(NODE, NO_HARDWARE, parameters)
        self._begin()

    def close(self) -> None:
        """Leave browsers and graph; a survey that runs continues."""
        self._in_loop(self._server.close())
        noted = threading.Event()
        self._loop.call_soon_threadsafe(self._notes.finish, noted.set)
        noted.wait(NOTES_LIMIT_S)
        for client in self._clients:
            client.close()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(CLOSE_LIMIT_S)
        for _until_s, lost in self._notes.waiting:
            rospy.logwarn("no log of a survey has this command: %s", lost)

    def _connect_clients(self) -> None:
        put, namespace = self._events.append, rospy.get_namespace()
        senders = Senders(namespace)
        self._control = ControlClient(put, senders)
        self._storage = StorageClient(put, senders)
        remote = RemoteControlClient(put, namespace)
        self._clients = (self._control, self._storage, remote)

    def _wait_for(self, service: Service, **fields: Any) -> Any:
        try:
            return self._storage.wait_for(service, **fields)
        except RequestError as error:
            raise NotNowError(error.message) from error

    def _new_shell(self, data: Path) -> Shell:
        return Shell(
            {
                "now": NowPage(rospy.get_namespace().strip("/")),
                "commands": self._commands,
                "map": GroundPage(self._storage, self._clock.now_s, self._warn),
                "surveys": SurveysPage(self._wait_for, self._storage.cancel, data),
                "service": ServicePage(self._storage.examine, self._clock),
            },
            self._logins,
        )

    def _begin(self) -> None:
        for client in self._clients:
            client.listen()
        self._thread.start()
        parameters = self._parameters

        async def listen() -> None:
            context = ssl_context(self._certificate)
            self._server.listen(parameters.address, parameters.port, context)

        self._in_loop(listen())
        self._loop.call_soon_threadsafe(self._beat)
        if not self._accounts.all():
            rospy.logwarn(
                "nobody can log in yet: rosrun gpr20_web users add NAME --role control --folder %s",
                parameters.path,
            )

    def _in_loop(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something in the thread of the loop, or raise what it raises."""
        asyncio.run_coroutine_threadsafe(work, self._loop).result(CALL_LIMIT_S)

    def _beat(self) -> None:
        self._loop.call_later(BEAT_S, self._beat)
        is_due = self._clock.now_s() - self._refreshed_s >= REST_S
        if not (is_due or self._server.streams or self._notes.last_tries):
            return
        with faults_logged("page"):  # the next beat shows what is true then
            while self._events:
                self._handle(self._events.popleft())
            self._refresh()

    def _handle(self, event: Any) -> None:
        if isinstance(event, Delivery):
            event.deliver()
            return
        self._model.handle(event)
        self._shell.on_event(event)

    def _refresh(self) -> None:
        now_s = self._refreshed_s = self._clock.now_s()
        watchers, holder = len(self._server.streams), self._lease.holder
        if watchers:
            self._watched_s = now_s
        is_watched = now_s - self._watched_s <= LINGER_S
        if is_watched and now_s - self._checked_s >= MASTER_CHECK_S:
            self._checked_s = now_s
            self._control.check_master()
        self._model.set_followed(is_watched)
        for client in (self._control, self._storage):
            client.set_watched(is_watched)
        snapshot = self._model.state()
        self._shell.show_state(snapshot)
        self._notes.refresh()
        self._server.streams.beat()
        status = WebStatusReported(
            self._parameters.reached_at(socket.gethostname()),
            *(self._parameters.port, self._certificate.fingerprint),
            *(watchers, "" if holder is None else holder.name),
        )
        if status != self._said:
            self._said = status
            self._status.publish(WebStatus(**asdict(status)))

    def _health(self) -> Health:
        problem = self._notes.problem
        values = {"watchers": len(self._server.streams)}
        if problem is not None:
            return WARN, problem, values
        return OK, Message("the page answers"), values

    @staticmethod
    def _warn(reason: Message) -> None:
        rospy.logwarn("%s", reason)

    @staticmethod
    def _report(error: BaseException) -> None:
        with faults_logged("page"):
            raise error


def main() -> None:
    """Run the node until ROS shuts down."""

    def build() -> WebNode:
        # The page is on the computer of the imaging node, and has the same surveys.
        data = data_folder(read_parameters(Dict[str, str], "imaging").get("data", ""), os.environ)
        node = WebNode(read_parameters(WebParameters, NODE), data)
        rospy.on_shutdown(node.close)
        return node

    run_node(NODE, build, needed=False)

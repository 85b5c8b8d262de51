"""The node web: the robot's topics and services in, browsers out."""

from __future__ import annotations

import os
import socket
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Mapping, Optional

import rospy

from gpr20_common.catalogue import language_from_environment, read_catalogue
from gpr20_common.high.answers import message_from
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.service_client import ServiceClient
from gpr20_common.low.clock import Clock
from gpr20_common.low.data_folder import data_folder
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NO_HARDWARE
from gpr20_msgs.msg import WebStatus
from gpr20_msgs.srv import AddFact
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.remote_control import RemoteControlClient
from gpr20_operator.high.robots_client import RobotsClient
from gpr20_operator.high.ros_events import (
    STORAGE_SILENT,
    RequestError,
    call,
)
from gpr20_operator.high.storage_client import FACT_TIMEOUT_S, StorageClient, fact_fields
from gpr20_operator.jobs.job import Delivery
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.remote_control import RemoteAllowance, WebStatusReported
from gpr20_operator.robot.robots import Robots
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.folder.log_record import Kind
from gpr20_web.errors import AuditFileError, NotNowError
from gpr20_web.high.event_loop import EventLoop
from gpr20_web.high.survey_services import RosSurveyServices
from gpr20_web.low.accounts import Accounts
from gpr20_web.low.certificate import ensure_certificate, ssl_context
from gpr20_web.low.cookies import Logins, ensure_key
from gpr20_web.low.doctor_program import make_bundle
from gpr20_web.low.http_server import HttpServer
from gpr20_web.low.notifier import Notifier
from gpr20_web.mid.all_pages import Surroundings, all_pages
from gpr20_web.mid.audit import Audit
from gpr20_web.mid.commands import Commands, Robot
from gpr20_web.mid.lease import Lease
from gpr20_web.mid.shell import Shell
from gpr20_web.mid.web_parameters import WebParameters

NODE = "web"
STATIC = Path(__file__).resolve().parent.parent / "static"
# As often as the window while somebody looks, else as seldom as a notice may be late.
MASTER_CHECK_S, SELDOM_S = 2.0, 15.0
CLOSE_LIMIT_S = 3.0
S_PER_HOUR = 3600.0


@dataclass(frozen=True)
class StoredSurveys:
    """Where the imaging node finds the surveys: the page is on the same computer.

    Attributes:
        data: Folder of the surveys; empty: $GPR20_DATA, or ~/gpr20_data if that is not set.
    """

    data: str = ""


class WebNode:
    """Everything connected; what is shown belongs to the thread of the event loop."""

    def __init__(self, parameters: WebParameters, data: Path) -> None:
        """Connect everything, and answer browsers.

        Raises:
            WebError: There is no certificate, the port is taken, or the accounts are damaged.
        """
        self._parameters, self._clock = parameters, Clock()
        self._checked_s = -SELDOM_S
        self._asks_for_robots = False
        self._said: Optional[WebStatusReported] = None
        self._events = EventLoop(self._handle, self._refresh, self._report)
        folder = parameters.path
        self._certificate = ensure_certificate(folder, (parameters.address,))
        self._accounts = Accounts(folder, self._clock)
        longest_s = parameters.session_hours * S_PER_HOUR
        self._logins = Logins(self._accounts, ensure_key(folder), longest_s, self._clock)
        self._facts = ServiceClient("add_fact", AddFact)
        self._audit = Audit(self._note_survey, self._warn, self._clock)
        self._model = SurveyModel(self._clock)
        self._connect_clients()
        language = language_from_environment(os.environ)
        self._notifier = Notifier(
            *(parameters.notified(), socket.gethostname()),
            *(read_catalogue(language).text, self._warn),
        )
        self._lease = Lease(self._clock, lambda session: self._server.streams.has(session))
        self._commands = Commands(
            Robot(self._model, self._control, RemoteAllowance(self._clock), self._clock),
            *(self._lease, self._audit.add),
        )
        self._shell = Shell(all_pages(self._surroundings(data)))
        self._server = HttpServer(
            tuple(self._shell.all_routes()), STATIC, self._logins.find, self._report
        )
        self._status = rospy.Publisher("web_status", WebStatus, queue_size=5, latch=True)
        self._diagnostics = Diagnostics(NODE, self._health)
        self._description = publish_description(NODE, NO_HARDWARE, parameters)
        self._begin()

    def close(self) -> None:
        """Leave browsers and graph; a survey that runs continues."""
        for client in self._clients:
            client.close()
        self._events.call(self._server.close)
        self._events.end()
        self._audit.close(CLOSE_LIMIT_S)
        self._notifier.close(CLOSE_LIMIT_S)

    def _connect_clients(self) -> None:
        put, senders = self._events.put, Senders(rospy.get_namespace())
        self._control = ControlClient(put, senders)
        self._storage = StorageClient(put, senders)
        self._robots = RobotsClient(put, senders)
        remote = RemoteControlClient(put, rospy.get_namespace())
        self._clients = (self._control, self._storage, self._robots, remote)

    def _surroundings(self, data: Path) -> Surroundings:
        namespace = rospy.get_namespace()
        return Surroundings(
            name=namespace.strip("/"),
            data=data,
            clock=self._clock,
            accounts=self._accounts,
            logins=self._logins,
            commands=self._commands,
            source=self._storage,
            requests=self._storage,
            services=RosSurveyServices(self._storage),
            robots=Robots(namespace, False, self._follow_robots),
            examine=self._storage.examine,
            make_bundle=partial(make_bundle, namespace),
            send=self._notifier.send,
            warn=self._warn,
        )

    def _begin(self) -> None:
        for client in self._clients:
            # Asking the master for the robots costs more than all the rest.
            if client is not self._robots:
                client.listen()
        self._events.begin()
        parameters = self._parameters

        async def listen() -> int:
            context = ssl_context(self._certificate)
            return self._server.listen(parameters.address, parameters.port, context)

        self._events.call(listen)
        if not self._accounts.all():
            rospy.logwarn(
                "nobody can log in yet: rosrun gpr20_web users add NAME --role control --folder %s",
                parameters.path,
            )

    def _follow_robots(self, watched: bool) -> None:
        if watched and not self._asks_for_robots:
            self._asks_for_robots = True
            self._robots.listen()
        self._robots.set_watched(watched)

    def _handle(self, event: Any) -> None:
        if isinstance(event, Delivery):
            event.deliver()
            return
        self._commands.take_refusal(self._model.handle(event))
        self._shell.on_event(event)

    def _refresh(self) -> bool:
        now_s = self._clock.now_s()
        watchers, holder = len(self._server.streams), self._lease.holder
        if now_s - self._checked_s >= (MASTER_CHECK_S if watchers else SELDOM_S):
            self._checked_s = now_s
            self._control.check_master()
        self._model.set_followed(watchers > 0)
        for client in (self._control, self._storage):
            client.set_watched(watchers > 0)
        self._shell.refresh(self._model.snapshot())
        self._server.streams.fresh_s = now_s
        status = WebStatusReported(
            self._parameters.reached_at(socket.gethostname()),
            *(self._parameters.port, self._certificate.fingerprint),
            *(watchers, "" if holder is None else holder.name),
        )
        if status != self._said:
            self._said = status
            self._status.publish(WebStatus(**asdict(status)))
        return watchers > 0

    def _note_survey(self, survey: str, values: Mapping[str, Any]) -> None:
        fields = fact_fields(survey, Kind.AUDIT, values)
        try:
            response = call(self._facts, STORAGE_SILENT, FACT_TIMEOUT_S, **fields)
        except RequestError as error:
            raise AuditFileError(error.message) from error  # it is tried again
        if not response.success:
            raise NotNowError(message_from(response))

    def _health(self) -> Health:
        problem = self._audit.problem
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
        stored = read_parameters(StoredSurveys, "imaging")
        node = WebNode(read_parameters(WebParameters, NODE), data_folder(stored.data, os.environ))
        rospy.on_shutdown(node.close)
        return node

    run_node(NODE, build, needed=False)

"""START and RESUME from the web page: only while a person at the robot allows them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import WEB, HealthLevel
from gpr20_operator.robot.condition import urgent
from gpr20_operator.robot.events import ControlState, StartPlan
from gpr20_operator.robot.snapshot import Snapshot

# How long one hold of the button allows them [s].
REMOTE_LIMIT_S = 600.0
# The window repeats it once a second; a link that loses packets may delay that.
REPORT_S = 1.0
SILENCE_S = 3.0

NOT_ALLOWED = Message(
    "Nobody at the robot allows it now: hold the button in Settings, REMOTE CONTROL, there"
)
NO_REPORT = Message("the touchscreen of the robot does not report that it is still allowed")
FAULT_CAME = Message("a fault came since it was allowed: it must be allowed at the robot again")
WAITING = Message("Waiting for the robot.")


@dataclass(frozen=True)
class RemoteArmed:
    """One message of `remote_control`; plan None: something in the fields is wrong."""

    armed: bool
    remaining_s: float = 0.0
    plan: Optional[StartPlan] = None


@dataclass(frozen=True)
class WebStatusReported:
    """One message of `web_status`.

    Attributes:
        fingerprint: Of the certificate, in groups for people to compare.
        watchers: How many have the page open.
        controller: Name of the person in control; empty: nobody.
    """

    address: str
    port: int
    fingerprint: str
    watchers: int
    controller: str

    @property
    def url(self) -> str:
        """What people write into a browser."""
        host = f"[{self.address}]" if ":" in self.address else self.address
        return f"https://{host}:{self.port}"


def remote_obstacle(snapshot: Snapshot) -> Optional[Message]:
    """Return why the robot can be allowed to nobody elsewhere now; None: it can."""
    alarm = urgent(snapshot)
    if alarm is not None:
        return alarm.message
    if snapshot.service is not None:
        return Message("In progress: {activity}", activity=snapshot.service)
    return None


class _FaultWatch:
    """Finds a fault that came since the hold: one that the person has seen does not count.

    So what is resumed from a distance may be a survey that a fault has paused.
    """

    def __init__(self) -> None:
        self._seen: Optional[ControlState] = None
        self.found = False

    def begin(self, snapshot: Optional[Snapshot]) -> None:
        self._seen, self.found = None if snapshot is None else snapshot.state, False

    def note(self, snapshot: Snapshot) -> None:
        state = snapshot.state
        if state != self._seen:
            # When it comes back, it is another one.
            self._seen = None
            self.found = self.found or (state is not None and state.is_fault)


class Arming:
    """The window's side: a hold begins it, a touch, a fault or 10 min end it. Of one thread.

    Args:
        clock: Measures the time.
        send: Takes what the web page is to know.

    Attributes:
        web: What the web page says of itself; None: there is none.
    """

    def __init__(self, clock: Clock, send: Callable[[RemoteArmed], None] = lambda _: None) -> None:
        self._clock, self._send = clock, send
        self._until_s = -math.inf
        self._faults = _FaultWatch()
        self._plan: Optional[StartPlan] = None
        self._sent: Optional[Tuple[bool, Optional[StartPlan]]] = None
        self._sent_s = -math.inf
        self.web: Optional[WebStatusReported] = None

    @property
    def remaining_s(self) -> float:
        """How long it still lasts [s]; 0: it is not armed."""
        return max(0.0, self._until_s - self._clock.now_s())

    @property
    def armed(self) -> bool:
        """Whether START and RESUME from the web page are allowed."""
        return self.remaining_s > 0.0

    def take(self, event: object) -> None:
        """Follow what the web page says."""
        if isinstance(event, WebStatusReported):
            self.web = event

    def arm(self, snapshot: Snapshot) -> None:
        """Note that the button was held; nothing is allowed where something forbids it."""
        if remote_obstacle(snapshot) is None:
            self._faults.begin(snapshot)
            self._until_s = self._clock.now_s() + REMOTE_LIMIT_S
        self._report()

    def touched(self) -> None:
        """Note a touch of the window: whoever is there decides alone."""
        self._until_s = -math.inf
        self._report()

    def note(self, snapshot: Snapshot, plan: Optional[StartPlan]) -> None:
        """Take what is known of the robot now, and the plan that the window shows."""
        self._plan = plan
        if any(one.name == WEB and one.level is HealthLevel.STALE for one in snapshot.health.nodes):
            self.web = None  # its node has ended; the next one reports itself
        self._faults.note(snapshot)
        if self._faults.found or remote_obstacle(snapshot) is not None:
            self._until_s = -math.inf
        self._report()

    def _report(self) -> None:
        """Send what has changed, and once a second that it is still armed."""
        now_s, remaining_s = self._clock.now_s(), self.remaining_s
        said = remaining_s > 0.0, self._plan
        if said != self._sent or (said[0] and now_s - self._sent_s >= REPORT_S):
            self._sent, self._sent_s = said, now_s
            self._send(RemoteArmed(said[0], remaining_s, self._plan))


class RemoteAllowance:
    """The web page's side: what the window allows, for as long as it says so. Of one thread."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._last = RemoteArmed(False)
        self._came_s = -math.inf
        self._faults = _FaultWatch()
        self._snapshot: Optional[Snapshot] = None

    def on_event(self, event: object) -> None:
        """Take a message of the window."""
        if isinstance(event, RemoteArmed):
            if event.armed and not self._last.armed:
                # Only the end of it, which the window reports, can make room for another hold.
                self._faults.begin(self._snapshot)
            self._last, self._came_s = event, self._clock.now_s()

    def note(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot
        self._faults.note(snapshot)

    @property
    def armed(self) -> bool:
        """Whether START and RESUME are allowed now."""
        return self.obstacle is None

    @property
    def remaining_s(self) -> float:
        """How long they are still allowed [s]; 0: they are not."""
        return self._left_s if self.armed else 0.0

    @property
    def plan(self) -> Optional[StartPlan]:
        """What START measures; None: the plan of the window is not complete."""
        return self._last.plan

    @property
    def obstacle(self) -> Optional[Message]:
        """Why START and RESUME are not allowed now; None: they are."""
        if self._last.armed and self._faults.found:
            return FAULT_CAME
        if self._last.armed and self._clock.now_s() - self._came_s > SILENCE_S:
            return NO_REPORT
        if not self._last.armed or not self._left_s > 0.0:
            return NOT_ALLOWED
        return WAITING if self._snapshot is None else remote_obstacle(self._snapshot)

    @property
    def _left_s(self) -> float:
        return min(self._last.remaining_s, REMOTE_LIMIT_S) - (self._clock.now_s() - self._came_s)

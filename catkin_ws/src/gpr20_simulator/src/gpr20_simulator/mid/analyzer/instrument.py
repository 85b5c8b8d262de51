"""The simulated network analyzer: an MS2026C as seen from its network socket."""

from __future__ import annotations

import functools
import re
import threading
import time
from typing import Callable, List, Optional, Set, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_simulator.errors import SceneError
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome
from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer.calibration import Calibration
from gpr20_simulator.mid.analyzer.front_panel import Change
from gpr20_simulator.mid.analyzer.identity import Identity
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.reply import Answer, Capture, Reply, ReplyWriter
from gpr20_simulator.mid.analyzer.scpi import HeaderPattern, ScpiCommand, ScpiError
from gpr20_simulator.mid.analyzer.sweep_control import SweepControl
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.trace_reader import TraceReader
from gpr20_simulator.mid.analyzer.vna_commands import SETTINGS, Numbers, on_off
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.analyzer.vna_settings import SettingQueue, VnaSettings

# Headers for which is known which query they are; clients use some dozens.
MOST_KNOWN_HEADERS = 256
ENDLESS_DIGITS = "1" * 40_000 + "X"
NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?")

Query = Callable[[Numbers, str], Answer]
Action = Callable[[str], None]
# A header as documented, and the numbers in it.
Place = Tuple[str, Numbers]


class SimulatedVna:
    """Executes messages: settings, sweeps, and data in the instrument's own formats.

    It is switched on with a continuous sweep. A query that it does not know gets no
    answer; a command or value that it does not know changes nothing.

    Args:
        sweeper: The receiver, with the sweep of power-on.
        clock: Its seconds are those of the sweeps.
        description: Identity and the details of its replies.
        faults: What goes wrong now.
        seconds_per_point: Time of one frequency of a sweep [s].
        capture: Gets the kind and the exact bytes of each data reply.
    """

    def __init__(
        self,
        sweeper: Sweeper,
        clock: Clock,
        description: InstrumentScene,
        faults: FaultBoard,
        seconds_per_point: float,
        capture: Capture = lambda _kind, _reply: None,
    ) -> None:
        self._sweeper = sweeper
        self._description = description
        self._faults = faults
        self._seconds_per_point = seconds_per_point
        self._lock = threading.Lock()
        self._settings = VnaSettings()
        self._settings.is_corrected = description.calibration_accuracy > 0
        self._network_lost = False
        self._writer = ReplyWriter(description, faults, capture)
        self._is_remote = False
        self._queue = SettingQueue(clock, description.setting_delay_s)
        self._identity = Identity(description, faults)
        self._calibration = Calibration(description, faults)
        self._control = SweepControl(sweeper, clock, faults, description, self._change_by_hand)
        self._traces = TraceReader(sweeper, faults, description, self._identity, self._calibration)
        self._queries = self._query_rules()
        self._find_query = functools.lru_cache(MOST_KNOWN_HEADERS)(self._search_query)
        self._actions = self._action_rules()
        self._unanswered = self._places_of(description.unanswered_queries)
        sweeper.set_continuous(True)

    @property
    def network_lost(self) -> bool:
        """Whether a reset has taken the network settings away."""
        with self._lock:
            return self._network_lost

    @property
    def is_remote(self) -> bool:
        """Whether a client has taken control from the front panel."""
        with self._lock:
            return self._is_remote

    def set_remote(self, remote: bool) -> None:
        """Take control from the front panel, or give it back; a message takes it, too."""
        with self._lock:
            self._is_remote = remote

    def is_reachable(self) -> bool:
        """Return whether clients can connect."""
        return not self._faults.is_on(VnaFault.LINK_GONE)

    def opened(self) -> NetworkFault:
        """Answer to a new link, unless a fault that stays keeps the network down."""
        if self._faults.is_permanent(VnaFault.HANG):
            return NetworkFault.NO_REPLY
        if self._faults.is_permanent(VnaFault.DROP) or not self.is_reachable():
            return NetworkFault.DROP_CONNECTIONS
        with self._lock:
            self._identity.connected()
        return NetworkFault.NONE

    def execute(self, message: bytes) -> Outcome:
        """Carry out the commands of one message."""
        if self._description.message_s > 0.0:
            # The time of a network and its client, not of the robot: it is never scaled.
            time.sleep(self._description.message_s)
        with self._lock:
            self._is_remote = True
            if self._faults.strikes(VnaFault.HANG):
                return Outcome(fault=NetworkFault.NO_REPLY)
            if self._faults.strikes(VnaFault.DROP) or not self.is_reachable():
                return Outcome(fault=NetworkFault.DROP_CONNECTIONS)
            self._queue.apply_due()
            reply = Reply()
            for command in scpi.split_message(message):
                if command.is_query and reply.is_full:
                    continue
                if command.header.upper() == "*RST" and not command.is_query:
                    # It power-cycles the instrument, and the address may be another one then.
                    self._network_lost = True
                    self._faults.set(VnaFault.LINK_GONE.value)
                    return Outcome(fault=NetworkFault.DROP_CONNECTIONS)
                answer = self._carry_out(command)
                if answer is not None:
                    reply.add(answer)
            written = self._writer.written(reply)
            if written and self._faults.strikes(VnaFault.LATE):
                return Outcome(written, NetworkFault.ANSWER_LATE)
            return Outcome(written)

    def clear(self) -> ClearSupport:
        """Forget half-done work: there is none, each message is done when it is taken."""
        if self._faults.strikes(VnaFault.NO_CLEAR):
            return ClearSupport.NO_PROCEDURE
        if self._faults.strikes(VnaFault.CLEAR_UNSUPPORTED):
            return ClearSupport.ERROR_8
        return ClearSupport.FULL

    def _carry_out(self, command: ScpiCommand) -> Optional[Answer]:
        try:
            if command.is_query:
                return self._ask(command)
            self._command(command)
        except ScpiError:
            # An argument that is not understood: no answer and no effect.
            return None
        return None

    def _ask(self, command: ScpiCommand) -> Optional[Answer]:
        found = self._find_query(command.header)
        if found is None:
            return None
        place, query = found
        if place in self._unanswered and self._faults.strikes(VnaFault.UNANSWERED_QUERY):
            return None
        answer = query(place[1], command.argument)
        if isinstance(answer, str) and NUMBER.fullmatch(answer):
            return ENDLESS_DIGITS if self._faults.strikes(VnaFault.ENDLESS_DIGITS) else answer
        return answer

    def _search_query(self, text: str) -> Optional[Tuple[Place, Query]]:
        """Return which query a header is, and what answers it; None if there is none."""
        for header, query in self._queries:
            numbers = header.match(text)
            if numbers is not None:
                return (header.pattern, numbers), query
        for setting in SETTINGS:
            numbers, reply = setting.header.match(text), setting.reply
            if numbers is not None and reply is not None:
                return (setting.header.pattern, numbers), functools.partial(self._read, reply)
        return None

    def _read(
        self, reply: Callable[[VnaSettings, Numbers], str], numbers: Numbers, _argument: str
    ) -> str:
        return reply(self._settings, numbers)

    def _places_of(self, queries: Tuple[str, ...]) -> Set[Place]:
        places = set()
        for query in queries:
            found = self._find_query(query.strip().rstrip("?"))
            if found is None:
                raise SceneError(
                    Message(
                        "unanswered_queries holds {query}; the simulated VNA has no such query",
                        query=repr(query),
                    )
                )
            places.add(found[0])
        return places

    def _command(self, command: ScpiCommand) -> None:
        for header, act in self._actions:
            if header.match(command.header) is not None:
                act(command.argument)
                return
        for setting in SETTINGS:
            numbers = setting.header.match(command.header)
            if numbers is not None and setting.store is not None:
                if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
                    self._calibration.note_write(setting.header.pattern)
                    change = functools.partial(setting.store, self._settings, numbers)
                    self._queue.put(functools.partial(self._apply, change, command.argument))
                return

    def _apply(self, change: Callable[[str], None], argument: str) -> None:
        try:
            change(argument)
        except ScpiError:
            # As on the instrument, only reading back shows that a value was not accepted.
            return
        self._configure()

    def _change_by_hand(self, change: Change) -> None:
        with self._lock:
            change(self._settings)
            self._configure()

    def _configure(self) -> None:
        plan = self._settings.plan(self._seconds_per_point, self._description.averaging)
        self._sweeper.configure(plan)

    def _query_rules(self) -> List[Tuple[HeaderPattern, Query]]:
        calibration, control = self._calibration, self._control
        rules: Tuple[Tuple[str, Query], ...] = (
            ("*IDN", lambda _n, _a: self._identity.text()),
            (":STATus:OPERation", lambda _n, _a: control.operation_status()),
            (":CALCulate#:DATA", lambda n, a: self._traces.calculated(self._settings, n, a)),
            (":TRACe[:DATA]", lambda _n, a: self._traces.trace_data(self._settings, a)),
            (":TRACe:PREamble", lambda _n, a: self._traces.preamble(self._settings, a)),
            (
                "[:SENSe#]:FREQuency:DATA",
                lambda n, _a: self._traces.frequencies(self._settings, n),
            ),
            (":INITiate:CONTinuous", lambda _n, _a: control.runs_continuously()),
            (":INITiate:HOLD", lambda _n, _a: control.is_held()),
            ("[:SENSe]:SWEep:TYPE", lambda _n, _a: control.sweep_type(self._settings)),
            (
                "[:SENSe]:CORRection:COLLect:STATus:ACCuracy",
                lambda _n, _a: str(calibration.accuracy(self._settings)),
            ),
            (
                "[:SENSe]:CORRection:COLLect:STATus",
                lambda _n, _a: str(calibration.collection),
            ),
            (
                "[:SENSe]:CORRection[:STATe]",
                lambda _n, _a: on_off(calibration.is_applied(self._settings)),
            ),
            ("[:SENSe]:CORRection:COLLect:TYPE", lambda _n, _a: calibration.type),
            (
                "[:SENSe]:CORRection:COLLect:INTerpolation[:STATe]",
                lambda _n, _a: on_off(calibration.is_interpolated),
            ),
            ("[:SENSe]:CALibration:STATe", lambda _n, _a: str(calibration.parameters)),
            (":SYSTem:OPTions", lambda _n, _a: self._identity.options()),
            (":INSTrument[:SELect]", lambda _n, _a: '"MWVNA"'),
            (":INSTrument:NSELect", lambda _n, _a: "26"),
        )
        return [(HeaderPattern(header), answer) for header, answer in rules]

    def _action_rules(self) -> List[Tuple[HeaderPattern, Action]]:
        control = self._control
        rules: Tuple[Tuple[str, Action], ...] = (
            (":INITiate[:IMMediate]", lambda _a: control.trigger(self._settings)),
            (":INITiate:CONTinuous", lambda a: control.set_continuous(self._settings, a)),
            (":INITiate:HOLD", lambda a: control.hold(self._settings, a)),
            ("[:SENSe]:SWEep:TYPE", lambda a: control.set_sweep_type(self._settings, a)),
            ("[:SENSe]:AVERage:CLEar", lambda _a: self._sweeper.restart_average()),
            ("[:SENSe]:CORRection[:STATe]", self._set_correction),
            (":SYSTem:PRESet", lambda _a: self._preset()),
        )
        return [(HeaderPattern(header), act) for header, act in rules]

    def _set_correction(self, argument: str) -> None:
        wanted = scpi.switch(argument)
        if wanted and not self._calibration.exists:
            raise ScpiError("there is no calibration to correct with")
        if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
            self._settings.is_corrected = wanted

    def _preset(self) -> None:
        self._queue.clear()
        self._settings = VnaSettings()
        self._configure()
        self._sweeper.set_continuous(True)

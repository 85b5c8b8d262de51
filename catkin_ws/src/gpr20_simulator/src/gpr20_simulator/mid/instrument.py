"""The simulated network analyzer: an MS2026C as seen from its network socket."""

from __future__ import annotations

import functools
import random
import threading
from typing import Callable, List, Optional, Tuple, Union

from gpr20_common.low.clock import Clock
from gpr20_simulator.low.vxi11_core import NetworkFault, Outcome
from gpr20_simulator.mid import scpi
from gpr20_simulator.mid.faults import FaultBoard, VnaFault
from gpr20_simulator.mid.scene import InstrumentScene
from gpr20_simulator.mid.scpi import HeaderPattern, ScpiCommand, ScpiError
from gpr20_simulator.mid.sweeper import Sweeper
from gpr20_simulator.mid.trace_reader import DataReply, TraceReader
from gpr20_simulator.mid.vna_commands import SETTINGS, SWEEP_TYPES, Numbers, on_off
from gpr20_simulator.mid.vna_settings import SettingQueue, VnaSettings

SWEEP_COMPLETE = 256
ALL_PARAMETERS_CALIBRATED = 15
COLLECTION_COMPLETED = 4
WRONG_IDENTITY = '"Rohde&Schwarz,ZNL6,SIMULATED,1.0"'

Answer = Union[str, DataReply]
Query = Callable[[Numbers, str], Answer]
Action = Callable[[str], None]
Capture = Callable[[str, bytes], None]


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
        self._capture = capture
        self._lock = threading.Lock()
        self._settings = VnaSettings()
        self._settings.is_corrected = description.calibration_accuracy > 0
        self._network_lost = False
        self._random = random.Random(0)
        self._queue = SettingQueue(clock, description.setting_delay_s)
        self._traces = TraceReader(sweeper, faults, description)
        self._queries = self._query_rules()
        self._actions = self._action_rules()
        sweeper.set_continuous(True)

    @property
    def network_lost(self) -> bool:
        """Whether a reset has taken the network settings away."""
        with self._lock:
            return self._network_lost

    def opened(self) -> NetworkFault:
        """Answer to a new link, unless a fault that stays keeps the network down."""
        if self._faults.is_permanent(VnaFault.HANG):
            return NetworkFault.NO_REPLY
        if self._faults.is_permanent(VnaFault.DROP):
            return NetworkFault.DROP_CONNECTIONS
        return NetworkFault.NONE

    def execute(self, message: bytes) -> Outcome:
        """Carry out the commands of one message."""
        with self._lock:
            if self._faults.strikes(VnaFault.HANG):
                return Outcome(fault=NetworkFault.NO_REPLY)
            if self._faults.strikes(VnaFault.DROP):
                return Outcome(fault=NetworkFault.DROP_CONNECTIONS)
            self._queue.apply_due()
            answers: List[Answer] = []
            for command in scpi.split_message(message):
                if command.header.upper() == "*RST" and not command.is_query:
                    # It power-cycles the instrument, and the address may be another one then.
                    self._network_lost = True
                    return Outcome(fault=NetworkFault.GO_SILENT)
                answer = self._carry_out(command)
                if answer is not None:
                    answers.append(answer)
            reply = self._reply(answers)
            if reply and self._faults.strikes(VnaFault.LATE):
                return Outcome(reply, NetworkFault.ANSWER_LATE)
            return Outcome(reply)

    def clear(self) -> None:
        """Forget half-done work: there is none, each message is done when it is taken."""

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
        for header, answer in self._queries:
            numbers = header.match(command.header)
            if numbers is not None:
                return answer(numbers, command.argument)
        for setting in SETTINGS:
            numbers = setting.header.match(command.header)
            if numbers is not None and setting.reply is not None:
                return setting.reply(self._settings, numbers)
        return None

    def _command(self, command: ScpiCommand) -> None:
        for header, act in self._actions:
            if header.match(command.header) is not None:
                act(command.argument)
                return
        for setting in SETTINGS:
            numbers = setting.header.match(command.header)
            if numbers is not None and setting.store is not None:
                if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
                    change = functools.partial(setting.store, self._settings, numbers)
                    self._queue.put(functools.partial(self._apply, change, command.argument))
                return

    def _apply(self, change: Callable[[str], None], argument: str) -> None:
        try:
            change(argument)
        except ScpiError:
            # As on the instrument, only reading back shows that a value was not accepted.
            return
        self._sweeper.configure(self._settings.plan(self._seconds_per_point))

    def _reply(self, answers: List[Answer]) -> bytes:
        if not answers or self._faults.strikes(VnaFault.SILENT):
            return b""
        parts = [one.encode("ascii") if isinstance(one, str) else one.block for one in answers]
        reply = b";".join(parts)
        if isinstance(answers[-1], str) or self._description.trailing_newline:
            reply += b"\n"
        if self._faults.strikes(VnaFault.GARBAGE):
            reply = bytes(self._random.getrandbits(8) for _ in range(len(reply)))
        for answer in answers:
            if isinstance(answer, DataReply):
                self._capture(answer.kind, reply)
        return reply

    def _query_rules(self) -> List[Tuple[HeaderPattern, Query]]:
        accuracy = self._description.calibration_accuracy
        is_calibrated = accuracy > 0
        rules: Tuple[Tuple[str, Query], ...] = (
            ("*IDN", lambda _n, _a: self._identity()),
            (":STATus:OPERation", lambda _n, _a: self._operation_status()),
            (":CALCulate#:DATA", lambda n, a: self._traces.calculated(self._settings, n, a)),
            (":TRACe[:DATA]", lambda _n, a: self._traces.trace_data(self._settings, a)),
            (":TRACe:PREamble", lambda _n, a: self._traces.preamble(self._settings, a)),
            (
                "[:SENSe#]:FREQuency:DATA",
                lambda n, _a: self._traces.frequencies(self._settings, n),
            ),
            (":INITiate:CONTinuous", lambda _n, _a: self._runs_continuously()),
            (":INITiate:HOLD", lambda _n, _a: on_off(not self._sweeper.is_running)),
            ("[:SENSe]:SWEep:TYPE", lambda _n, _a: self._sweep_type()),
            (
                "[:SENSe]:CORRection:COLLect:STATus:ACCuracy",
                lambda _n, _a: str(accuracy if self._settings.is_corrected else 0),
            ),
            (
                "[:SENSe]:CORRection:COLLect:STATus",
                lambda _n, _a: str(COLLECTION_COMPLETED if is_calibrated else 0),
            ),
            ("[:SENSe]:CORRection[:STATe]", lambda _n, _a: on_off(self._settings.is_corrected)),
            (
                "[:SENSe]:CALibration:STATe",
                lambda _n, _a: str(ALL_PARAMETERS_CALIBRATED if is_calibrated else 0),
            ),
            (":SYSTem:OPTions", lambda _n, _a: self._options()),
            (":INSTrument[:SELect]", lambda _n, _a: '"MWVNA"'),
            (":INSTrument:NSELect", lambda _n, _a: "26"),
        )
        return [(HeaderPattern(header), answer) for header, answer in rules]

    def _action_rules(self) -> List[Tuple[HeaderPattern, Action]]:
        rules: Tuple[Tuple[str, Action], ...] = (
            (":INITiate[:IMMediate]", lambda _a: self._trigger()),
            (":INITiate:CONTinuous", lambda a: self._set_continuous(scpi.switch(a))),
            (":INITiate:HOLD", lambda a: self._sweeper.hold(scpi.switch(a))),
            ("[:SENSe]:SWEep:TYPE", self._set_sweep_type),
            ("[:SENSe]:AVERage:CLEar", lambda _a: self._sweeper.restart_average()),
            ("[:SENSe]:CORRection[:STATe]", self._set_correction),
            (":SYSTem:PRESet", lambda _a: self._preset()),
        )
        return [(HeaderPattern(header), act) for header, act in rules]

    def _identity(self) -> str:
        if self._faults.strikes(VnaFault.WRONG_IDENTITY):
            return WRONG_IDENTITY
        one = self._description
        # The instrument wraps its identity in double quotes.
        return f'"{one.manufacturer},{one.model},{one.serial},{one.firmware}"'

    def _options(self) -> str:
        _model, _slash, options = self._description.model.partition("/")
        return options or "NONE"

    def _operation_status(self) -> str:
        return str(SWEEP_COMPLETE if self._sweeper.is_complete else 0)

    def _runs_continuously(self) -> str:
        return on_off(self._sweeper.is_continuous and self._sweeper.is_running)

    def _sweep_type(self) -> str:
        if self._settings.is_external:
            return "EXT"
        return "CONT" if self._sweeper.is_continuous else "SING"

    def _trigger(self) -> None:
        # With an external trigger nothing but that trigger starts a sweep; there is none here.
        if not self._settings.is_external:
            self._sweeper.trigger(stale=self._faults.strikes(VnaFault.STALE))

    def _set_continuous(self, continuous: bool) -> None:
        self._settings.is_external = False
        self._sweeper.set_continuous(continuous)

    def _set_sweep_type(self, argument: str) -> None:
        sweep_type = scpi.chosen_keyword(argument, SWEEP_TYPES)
        if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
            self._settings.is_external = sweep_type == "EXT"
            self._sweeper.set_continuous(sweep_type == "CONT")

    def _set_correction(self, argument: str) -> None:
        wanted = scpi.switch(argument)
        if wanted and self._description.calibration_accuracy == 0:
            raise ScpiError("there is no calibration to correct with")
        if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
            self._settings.is_corrected = wanted

    def _preset(self) -> None:
        self._queue.clear()
        self._settings = VnaSettings()
        self._sweeper.configure(self._settings.plan(self._seconds_per_point))
        self._sweeper.set_continuous(True)

"""The simulated network analyzer: an MS2026C, message by message."""

from __future__ import annotations

import functools
import random
import re
import threading
from collections import deque
from typing import Callable, Deque, List, Optional, Tuple, Union

from gpr20_common.low.clock import Clock
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome
from gpr20_simulator.mid.analyzer import vna_settings
from gpr20_simulator.mid.analyzer.data_blocks import DataBlock, DataBlocks
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.vna_settings import (
    CHANGES_BY_HAND,
    SETTINGS,
    TRACES,
    Change,
    HeaderPattern,
    Numbers,
    ScpiCommand,
    ScpiError,
    Setting,
    VnaSettings,
)
from gpr20_simulator.mid.faults import FaultBoard, VnaFault
from gpr20_simulator.mid.world.scene import NOT_CALIBRATED, InstrumentScene

SWEEP_COMPLETE = 256
WRONG_IDENTITY = '"Rohde&Schwarz,ZNL6,SIMULATED,1.0"'
ENDLESS_DIGITS = "1" * 40_000 + "X"
NUMBER = re.compile(r"[-+]?[0-9]+(?:\.[0-9]+)?")

Answer = Union[str, DataBlock]
Query = Callable[[Numbers, str], Answer]
Action = Callable[[Numbers, str], None]
Capture = Callable[[str, bytes], None]


class SimulatedVna:
    """Executes messages: settings, sweeps, and data in the instrument's own formats.

    It is switched on with a continuous sweep. A query that it does not know gets no
    answer; a command or value that it does not know changes nothing.

    Args:
        sweeper: The receiver, with the sweep of power-on.
        clock: Its seconds are those of the sweeps.
        seconds_per_point: Time of one frequency of a sweep [s].
        capture: Gets the kind and the exact bytes of each data reply.

    Attributes:
        description: What it is like.
        is_remote: Whether a client has taken control from the front panel.
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
        self.is_remote = False
        self._sweeper = sweeper
        self._clock = clock
        self.description = description
        self._faults = faults
        self._seconds_per_point = seconds_per_point
        self._capture = capture
        self._lock = threading.Lock()
        self._random = random.Random(0)
        self._settings = VnaSettings()
        # Settings that have no effect yet, and when they have [s].
        self._waiting: Deque[Tuple[float, Callable[[], None]]] = deque()
        self._is_other_unit = False
        self._bit_set_until_s: Optional[float] = None
        self._blocks = DataBlocks(sweeper, faults, description)
        self._queries = self._query_rules()
        self._find_query = functools.lru_cache()(self._search_query)
        self._actions = self._action_rules()
        sweeper.set_continuous(True)

    def set_remote(self, remote: bool) -> None:
        """Take control from the front panel, or give it back; a message takes it, too."""
        self.is_remote = remote

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
            # It may find another unit at this address.
            self._is_other_unit = self._faults.strikes(VnaFault.OTHER_SERIAL)
        return NetworkFault.NONE

    def execute(self, message: bytes) -> Outcome:
        """Carry out the commands of one message."""
        with self._lock:
            self.is_remote = True
            if self._faults.strikes(VnaFault.HANG):
                return Outcome(fault=NetworkFault.NO_REPLY)
            if self._faults.strikes(VnaFault.DROP) or not self.is_reachable():
                return Outcome(fault=NetworkFault.DROP_CONNECTIONS)
            self._apply_due()
            answers: List[Answer] = []
            for command in vna_settings.split_message(message):
                if command.header.upper() == "*RST" and not command.is_query:
                    # It power-cycles the instrument, and the address may be another one then.
                    self._faults.set(VnaFault.LINK_GONE.value)
                    return Outcome(fault=NetworkFault.DROP_CONNECTIONS)
                answer = self._carry_out(command)
                if answer is not None:
                    answers.append(answer)
            written = self._written(answers)
            if written and self._faults.strikes(VnaFault.LATE):
                return Outcome(written, NetworkFault.ANSWER_LATE)
            return Outcome(written)

    def clear(self) -> ClearSupport:
        """Forget half-done work: there is none, each message is done when it is taken."""
        return ClearSupport.FULL

    def _written(self, answers: List[Answer]) -> bytes:
        """Return the reply to one message as it is sent; empty if there is none."""
        if not answers or self._faults.strikes(VnaFault.SILENT):
            return b""
        parts = [one.encode("ascii") if isinstance(one, str) else one.data for one in answers]
        reply = b";".join(parts) + b"\n"
        if self._faults.strikes(VnaFault.GARBAGE):
            reply = bytes(self._random.getrandbits(8) for _ in range(len(reply)))
        for answer in answers:
            if isinstance(answer, DataBlock):
                self._capture(answer.kind, reply)
        return reply

    def _carry_out(self, command: ScpiCommand) -> Optional[Answer]:
        try:
            if command.is_query:
                return self._ask(command)
            self._command(command)
        except ScpiError:
            # As on the instrument, only reading back shows that a value was not accepted.
            return None
        return None

    def _ask(self, command: ScpiCommand) -> Optional[Answer]:
        found = self._find_query(command.header)
        if found is None:
            return None
        query, numbers = found
        answer = query(numbers, command.argument)
        if isinstance(answer, str) and NUMBER.fullmatch(answer):
            return ENDLESS_DIGITS if self._faults.strikes(VnaFault.ENDLESS_DIGITS) else answer
        return answer

    def _search_query(self, text: str) -> Optional[Tuple[Query, Numbers]]:
        """Return what answers a header, and the numbers in it; None if there is no such query."""
        for header, query in self._queries:
            numbers = header.match(text)
            if numbers is not None:
                return query, numbers
        return None

    def _query_rules(self) -> List[Tuple[HeaderPattern, Query]]:
        sweeper = self._sweeper
        rules: Tuple[Tuple[str, Callable[..., Answer]], ...] = (
            ("*IDN", self._identity),
            (":STATus:OPERation", lambda *_a: str(SWEEP_COMPLETE if self._bit() else 0)),
            (":CALCulate#:DATA", self._calculated),
            (":TRACe:PREamble", self._preamble),
            ("[:SENSe#]:FREQuency:DATA", self._frequencies),
            (":INITiate:CONTinuous", lambda *_a: _number(sweeper.runs_continuously)),
            ("[:SENSe]:CORRection[:STATe]", lambda *_a: _number(self._is_corrected())),
            ("[:SENSe]:CORRection:COLLect:STATus:ACCuracy", self._accuracy),
            (
                "[:SENSe]:CALibration:STATe",
                lambda *_a: _number(self.description.calibrated_parameters * self._is_calibrated()),
            ),
        )
        found = [(HeaderPattern(header), answer) for header, answer in rules]
        return found + [(one.header, functools.partial(self._read, one)) for one in SETTINGS]

    def _read(self, setting: Setting, numbers: Numbers, _argument: str) -> str:
        return setting.reply(self._settings, numbers)

    def _calculated(self, numbers: Numbers, argument: str) -> DataBlock:
        vna_settings.chosen_keyword(argument, ("SDATa",))
        return self._blocks.sweep(self._settings, numbers)

    def _frequencies(self, numbers: Numbers, _argument: str) -> DataBlock:
        return self._blocks.frequencies(self._settings, numbers)

    def _preamble(self, _numbers: Numbers, argument: str) -> DataBlock:
        number = vna_settings.whole_number_between(argument or "1", 1, TRACES)
        return self._blocks.preamble(self._settings, number, self._serial(), self._is_corrected())

    def _identity(self, _numbers: Numbers, _argument: str) -> str:
        if self._faults.strikes(VnaFault.WRONG_IDENTITY):
            return WRONG_IDENTITY
        one = self.description
        # The instrument wraps its identity in double quotes.
        return f'"{one.manufacturer},{one.model},{self._serial()},{one.firmware}"'

    def _serial(self) -> str:
        is_other = self._is_other_unit or self._faults.is_on(VnaFault.SWAPPED)
        return self.description.other_serial if is_other else self.description.serial

    def _is_calibrated(self) -> bool:
        """Return whether there is a calibration that can be applied."""
        is_lost = self._faults.has_damaged(VnaFault.LOSES_CALIBRATION)
        return self.description.calibration_accuracy != NOT_CALIBRATED and not is_lost

    def _is_corrected(self) -> bool:
        """Return whether it is applied."""
        return self._settings.is_corrected and self._is_calibrated()

    def _accuracy(self, _numbers: Numbers, _argument: str) -> str:
        if not self._is_corrected():
            return str(NOT_CALIBRATED)
        return str(self.description.calibration_accuracy)

    def _bit(self) -> bool:
        """Return whether the end of a sweep is shown."""
        if self._bit_set_until_s is not None:
            if self._clock.now_s() < self._bit_set_until_s:
                return True
            self._bit_set_until_s = None
        return self._sweeper.is_complete

    def _action_rules(self) -> List[Tuple[HeaderPattern, Action]]:
        sweeper = self._sweeper
        rules: Tuple[Tuple[str, Action], ...] = (
            (":INITiate[:IMMediate]", lambda _n, _a: self._trigger()),
            (":INITiate:CONTinuous", lambda _n, a: sweeper.set_continuous(vna_settings.switch(a))),
        )
        found = [(HeaderPattern(header), act) for header, act in rules]
        return found + [(one.header, functools.partial(self._store, one)) for one in SETTINGS]

    def _command(self, command: ScpiCommand) -> None:
        for header, act in self._actions:
            numbers = header.match(command.header)
            if numbers is not None:
                act(numbers, command.argument)
                return

    def _store(self, setting: Setting, numbers: Numbers, argument: str) -> None:
        if self._faults.strikes(VnaFault.REFUSE_SETTINGS):
            return
        if setting.is_calibrated:
            self._faults.damages(VnaFault.LOSES_CALIBRATION)
        # The instrument may keep a setting back, for up to two seconds.
        due_s = self._clock.now_s() + self.description.setting_delay_s
        store = functools.partial(setting.store, self._settings, numbers, argument)
        self._waiting.append((due_s, store))
        self._apply_due()

    def _apply_due(self) -> None:
        while self._waiting and self._waiting[0][0] <= self._clock.now_s():
            _due_s, store = self._waiting.popleft()
            try:
                store()
            except ScpiError:
                # As on the instrument, only reading back shows that a value was not accepted.
                continue
            self._configure()

    def _configure(self) -> None:
        self._sweeper.configure(self._settings.plan(self._seconds_per_point))

    def _trigger(self) -> None:
        """Run one sweep."""
        keeps_bit = self._bit() and self._faults.strikes(VnaFault.LATE_BIT)
        self._bit_set_until_s = (
            self._clock.now_s() + self.description.late_bit_s if keeps_bit else None
        )
        changes = [
            change for fault, change in CHANGES_BY_HAND.items() if self._faults.strikes(fault)
        ]
        is_late = self._faults.strikes(VnaFault.LATE_MEMORY)
        is_slow = self._faults.strikes(VnaFault.SLOW_POINTS)
        self._sweeper.trigger(
            stale=self._faults.strikes(VnaFault.STALE),
            slowest_point_s=self.description.slow_point_s if is_slow else 0.0,
            shown_late_s=self.description.late_memory_s if is_late else 0.0,
            midway=functools.partial(self._change_by_hand, changes) if changes else None,
        )

    def _change_by_hand(self, changes: List[Change]) -> None:
        """Change settings from the thread of the sweeps, in the middle of one."""
        for change in changes:
            with self._lock:
                change(self._settings)
                self._configure()


def _number(value: int) -> str:
    """Return a number or a truth value as the instrument writes it."""
    return str(int(value))

"""What an MS2026C shows: the data of the last sweep, or still those of an older one."""

from __future__ import annotations

from typing import Optional

import numpy as np

from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError, data_changed, old_data
from gpr20_vna_acquisition.mid.block_parser import TransferFormat, parse_numbers
from gpr20_vna_acquisition.mid.exchanges import Exchanges
from gpr20_vna_acquisition.mid.ms2026c_commands import DATA_QUERY
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.sweep_timing import has_old_points
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters


class Display:
    """Reads data, and shows that they are those of the sweep that was triggered last.

    The manual does not define whether the display has the data of a sweep when the bit of its end
    is set. Data with points of the sweep before are read again until they have none. That is enough
    as long as nothing older could reach the display any more: then whatever is new is of this
    sweep. The first sweep is therefore proven by data that are the same after the longest time for
    which a display may lag, every later one by data that are the same when it is confirmed.
    """

    def __init__(
        self, exchanges: Exchanges, parameters: VnaParameters, deadline: RequestDeadline
    ) -> None:
        self._exchanges = exchanges
        self._parameters = parameters
        self._deadline = deadline
        # What the next sweep must differ from; None if nothing was shown before.
        self.shown: Optional[np.ndarray] = None
        # The answer with them, and the same of a trace that is not proven yet.
        self._answer = b""
        self._unproven: Optional[bytes] = None
        # Whether nothing older than the last sweep can still come, and when that sweep ended.
        self._settled = False
        self._ended_s = 0.0
        # Whether it was seen to lag behind an average, which changes it several times.
        self._lags = False

    @property
    def is_proven(self) -> bool:
        """Whether there are no data that `prove` has to read again."""
        return self._unproven is None

    def begin_set_up(self, settings: SweepSettings) -> None:
        """Forget everything; read what is shown before the first sweep, if anything is."""
        self._unproven, self._settled, self._lags = None, False, False
        try:
            self.look(settings)
        except VnaDataError:
            # Nothing was measured with these settings yet.
            self.shown = None

    def read(self, settings: SweepSettings) -> np.ndarray:
        """Return the numbers that are shown now: real and imaginary part of each point in turn."""
        self._answer = self._exchanges.ask_raw(DATA_QUERY)
        return self._numbers(self._answer, settings)

    def look(self, settings: SweepSettings) -> None:
        """Remember what is shown now as what the next sweep must differ from."""
        self.shown = self.read(settings)

    def new_numbers(self, settings: SweepSettings, cleared: bool) -> np.ndarray:
        """Return numbers of which every one is new.

        Args:
            settings: With which they were measured.
            cleared: Whether the bit of the sweep before was seen cleared. If not, the data must
                also be the same twice.

        Raises:
            VnaOldDataError: Some stay those of the sweep before.
        """
        before = self.shown
        # Single precision has no equal points by chance.
        exact = self._parameters.transfer_format is TransferFormat.REAL32
        limit_s = self._deadline.now_s() + self._parameters.settle_s
        numbers, steady = self.read(settings), cleared
        while True:
            is_old = has_old_points(numbers, before, to_the_last=exact or not cleared)
            if steady and not is_old:
                self.shown = numbers
                return numbers
            if self._deadline.now_s() >= limit_s:
                raise old_data()
            if is_old:
                self._deadline.pause_s(self._parameters.poll_interval_s)
            again = self.read(settings)
            steady, numbers = cleared or np.array_equal(numbers, again), again

    def new_trace(self, settings: SweepSettings, cleared: bool, was_settled: bool) -> np.ndarray:
        """Return the numbers of a trace whose sweeps have ended now; `prove` proves them.

        Args:
            settings: With which they were measured.
            cleared: As for `new_numbers`.
            was_settled: What `begin_trace` returned.
        """
        self._ended_s = self._deadline.now_s()
        if self._lags:
            self._deadline.pause_s(self._parameters.display_settle_s)
        numbers = self.new_numbers(settings, cleared)
        self._unproven = self._answer
        # An average changes the display several times.
        self._settled = was_settled and settings.analyzer.averages <= 1
        return numbers

    def begin_trace(self) -> bool:
        """Note that a trace is triggered; return whether nothing older than it can come."""
        was_settled, self._settled, self._unproven = self._settled, False, None
        return was_settled

    def prove(self, settings: SweepSettings) -> None:
        """Read the data of the last trace again; they must have the same bits.

        Raises:
            VnaOldDataError: They have not: the display followed the end of the sweep too late.
        """
        if self._unproven is None:
            return
        waits = not self._settled
        if waits:
            settled_s = self._ended_s + self._parameters.display_settle_s
            self._deadline.pause_s(max(0.0, settled_s - self._deadline.now_s()))
        again = self._exchanges.ask_raw(DATA_QUERY)
        if again == self._unproven:
            self._settled, self._unproven = True, None
            return
        # Data that cannot be read prove nothing: they are read once more.
        self.shown = self._numbers(again, settings)
        # After the wait nothing of an older sweep can come any more.
        self._settled, self._unproven = waits, None
        self._lags = settings.analyzer.averages > 1
        raise data_changed()

    def _numbers(self, answer: bytes, settings: SweepSettings) -> np.ndarray:
        return parse_numbers(answer, self._parameters.transfer_format, 2 * settings.points)

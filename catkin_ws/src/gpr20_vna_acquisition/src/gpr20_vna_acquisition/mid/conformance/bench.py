"""What every check of an analyzer needs: objects of its class, time limits, and the result."""

from __future__ import annotations

import enum
import threading
from dataclasses import dataclass, replace
from typing import Any, Callable, List, Optional, Sequence, Tuple

from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition.errors import VnaError, VnaNotReadyError, VnaSettingError
from gpr20_vna_acquisition.mid.analyzer import Analyzer
from gpr20_vna_acquisition.mid.analyzers import make_analyzer
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# Frequencies are whole ones where the range allows it.
WHOLE_HZ = 1e6


class Status(enum.Enum):
    """How a check ended."""

    PASSED = "passed"
    FAILED = "failed"
    MEASURED = "measured"  # what the instrument does, neither good nor bad
    NOT_TESTED = "not tested"


Outcome = Tuple[Status, Message]


class NotAsPromisedError(VnaError):
    """An analyzer breaks a promise of the protocol."""

    fault = CONFIGURATION


@dataclass(frozen=True)
class Extent:
    """How much is tried.

    Attributes:
        points: Points of a sweep.
        bandwidths_hz: IF bandwidths [Hz], the widest first; those that the analyzer does not have
            are left out.
        sweeps: How many sweeps are compared.
        traces: How many sweeps are made with each fault.
        limit_s: How long one check may take [s], and the longest wait for an answer in it [s].
        longest_lag_s: How long the display is watched after the end of a sweep [s].
    """

    points: int = 51
    bandwidths_hz: Tuple[float, ...] = (100_000.0, 10_000.0, 1000.0, 100.0)
    sweeps: int = 20
    traces: int = 4
    limit_s: float = 40.0
    longest_lag_s: float = 1.2


class Bench:
    """Makes objects of the class that is checked, and limits the time of what they do."""

    def __init__(
        self,
        parameters: VnaParameters,
        connect_vxi11: Callable[[str], Transport],
        extent: Extent,
    ) -> None:
        """Begin without an analyzer.

        Args:
            parameters: The configuration of the analyzer.
            connect_vxi11: Opens a VXI-11 link to an address.
            extent: How much is tried.
        """
        self.parameters = parameters
        self.connect_vxi11 = connect_vxi11
        self.extent = extent
        self.clock = Clock()
        self.deadline = RequestDeadline(self.clock)
        self._made: List[Analyzer] = []
        lowest_hz, highest_hz = parameters.min_frequency_hz, parameters.max_frequency_hz
        first, middle, last = (
            _whole(lowest_hz + part * (highest_hz - lowest_hz)) for part in (0.1, 0.5, 0.9)
        )
        self.low = SweepSettings(first, middle, extent.points)
        self.high = SweepSettings(middle, last, extent.points)

    def begin(self) -> None:
        """Begin a check, with its time limit."""
        self.deadline.begin(self.extent.limit_s, extensible=True)

    def pause_s(self, duration_s: float) -> None:
        """Wait [s]."""
        self.clock.wait_s(threading.Event(), duration_s)

    def made(self, connect_vxi11: Any = None, **changes: Any) -> Analyzer:
        """Return a new object of the class.

        Args:
            connect_vxi11: Opens its links; None: as those of the others.
            changes: Parameters that are different for it.
        """
        parameters = replace(self.parameters, **changes)
        connect = connect_vxi11 or self.connect_vxi11
        self._made.append(make_analyzer(parameters, connect, self.deadline))
        return self._made[-1]

    def linked(self, analyzer: Analyzer) -> str:
        """Make a link and return the identification."""
        analyzer.connect(self.parameters.address)
        return analyzer.identify()

    def set_up(self, settings: SweepSettings) -> Tuple[Analyzer, SweepSettings]:
        """Return a new object with a link, and the settings that it has confirmed."""
        analyzer = self.made()
        self.linked(analyzer)
        return analyzer, analyzer.configure(settings)

    def relink(self, analyzer: Analyzer, accepted: SweepSettings) -> None:
        """Make a new link, and the settings again where they are not confirmed."""
        analyzer.disconnect()
        self.linked(analyzer)
        if refusal_of(analyzer.confirm) is not None:
            analyzer.configure(accepted)

    def change_by_another(self, *settings: SweepSettings) -> None:
        """Let another object make settings, one after the other, over a link of its own."""
        other = self.made()
        self.linked(other)
        for one in settings:
            other.configure(one)
        other.disconnect()

    def clear(self) -> None:
        """Leave the instrument sweeping by itself, without any link."""
        for analyzer in self._made:
            analyzer.release()
            analyzer.disconnect()
        self._made.clear()


def with_bandwidth(settings: SweepSettings, bandwidth_hz: float) -> SweepSettings:
    """Return the same sweep with an IF bandwidth [Hz]."""
    return replace(settings, analyzer=AnalyzerSettings(bandwidth_hz, 1))


def confirmed(analyzer: Analyzer, count: int) -> Sequence[Sweep]:
    """Return so many sweeps, each confirmed."""
    sweeps = []
    for _ in range(count):
        sweeps.append(analyzer.sweep())
        analyzer.confirm()
    return sweeps


def refusal_of(action: Callable[[], Any]) -> Optional[VnaError]:
    """Do something; return the error with which the analyzer refuses it, None if it does not."""
    try:
        action()
    except VnaError as error:
        return error
    return None


def check_noticed(refusal: Optional[VnaError]) -> None:
    """Check that settings which were changed were not confirmed.

    Args:
        refusal: What `confirm` said.

    Raises:
        NotAsPromisedError: They were.
        VnaError: It said something else.
    """
    if refusal is None:
        raise NotAsPromisedError(Message("it confirms settings that were changed"))
    if not isinstance(refusal, (VnaSettingError, VnaNotReadyError)):
        raise refusal


def put_back(noticed: bool) -> Message:
    """Return whether settings that were changed and put back are noticed."""
    if noticed:
        return Message("settings that were changed and put back are noticed")
    return Message("settings that were changed and put back are not noticed")


def _whole(frequency_hz: float) -> float:
    return round(frequency_hz / WHOLE_HZ) * WHOLE_HZ if frequency_hz > WHOLE_HZ else frequency_hz

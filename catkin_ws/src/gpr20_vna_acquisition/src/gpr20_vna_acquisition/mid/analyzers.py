"""The analyzer that a robot is configured for: an MS2026C, or a class of another package.

And what its last check found: a file in the folder of the configuration.
"""

from __future__ import annotations

import contextlib
import enum
import functools
import hashlib
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import (
    Any,
    Callable,
    Dict,
    Mapping,
    Optional,
    Protocol,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    Union,
)

from gpr20_common import __version__
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message
from gpr20_common.mid.checks import is_extension, load_extension, options_refused
from gpr20_survey.files.durable_files import replace_file
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import CalibrationStatus, Sweep, SweepSettings
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline, Transport
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C, STEP_MARGIN_S, VnaParameters

Answer = TypeVar("Answer")
FILE = "checked_analyzer.json"
FORMAT = "gpr20-analyzer-check/1"


class Analyzer(Protocol):
    """One network analyzer.

    The driver makes one object, which remembers what it learns about the instrument over all
    links. Making one opens no link: the check before a launch makes one, too. Every method may
    raise `VnaConnectionError`; after that the link is dead, and the driver calls `disconnect` and
    `connect`. The driver limits the time of each request, retries and reconnects; an analyzer does
    not retry. One thread calls at a time. A call that does not return ends the process of the
    driver, which is started again. A class may also have `temperature_c`, its temperature at the
    last `confirm` [degC], and `calibration_details`, which returns what else it says of its
    calibration, for survey.json.
    """

    def connect(self, address: str) -> None:
        """Open a link to an address, with empty buffers; an open one is closed.

        Raises:
            InvalidValueError: The address is not one of this kind of analyzer.
            VnaConnectionError: Nothing answers there.
        """

    def identify(self) -> str:
        """Return the identification: maker, model, serial number, firmware.

        Raises:
            VnaIdentityError: It is not the expected kind of instrument.
        """

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse settings that this kind of analyzer does not have; no link is needed.

        Raises:
            InvalidValueError: A value is not allowed; the message says what is.
        """

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Set up S21 over frequency, hold the sweep, and measure how long a trace takes.

        The settings are read first, and only those that differ are written: writing may end the
        instrument's calibration.

        Returns:
            The settings as read back; what was left to the instrument has its value.

        Raises:
            VnaSettingError: The instrument did not accept a setting.
            VnaCalibrationError: Writing a setting ended its calibration.
            VnaDataError: It accepted them, but measures other frequencies.
        """

    def sweep(self) -> Sweep:
        """Trigger the sweeps of one trace, wait for their end and return the data.

        The data are fresh, but only `confirm` shows that the settings were those of `configure`.
        The driver refuses data with every bit of the sweep before.

        Raises:
            VnaSweepError: It did not end in time.
            VnaDataError: The data are stale, incomplete or not finite.
        """

    def confirm(self) -> None:
        """Return if every setting that the data depend on is still that of `configure`.

        It is called while the axes move. An analyzer that shows data which can follow the end of a
        sweep reads those of the last sweep again.

        Raises:
            VnaSettingError: One was changed by hand, or is lost.
            VnaOldDataError: The data that were read are not what the analyzer shows now.
            VnaNotReadyError: `configure` has not succeeded with this instrument.
        """

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration."""

    def release(self) -> None:
        """Leave the instrument sweeping by itself, with its front panel usable.

        Never fails, and ends within seconds also after the driver was shut down.
        """

    def disconnect(self) -> None:
        """End the link; never fails, and does nothing without one."""

    @property
    def trace_duration_s(self) -> Optional[float]:
        """How long one trace takes, with its averages [s]; None before `configure`."""

    @property
    def remarks(self) -> Sequence[Message]:
        """What was learned about this instrument that a technician should know."""


# What the driver uses: an `Analyzer` that has `temperature_c` and `calibration_details`, too.
DrivenAnalyzer = Union[Ms2026c, "ForeignAnalyzer"]


def make_analyzer(
    parameters: VnaParameters, connect_vxi11: Callable[[str], Transport], deadline: RequestDeadline
) -> DrivenAnalyzer:
    """Return the analyzer that a robot is configured for; it has no link yet.

    Args:
        parameters: The configuration.
        connect_vxi11: Opens a VXI-11 link to an address.
        deadline: Ends a request that takes too long.

    Raises:
        InvalidValueError: A class outside this package cannot be used.
        Gpr20Error: What the class itself says of its options.
    """
    if parameters.analyzer != MS2026C:
        return make_foreign_analyzer(parameters, deadline)
    return Ms2026c(connect_vxi11, parameters, deadline)


def load_analyzer(parameters: VnaParameters) -> Type:
    """Return the class that the parameters name; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no analyzer, or has other options.
    """
    name, options = parameters.analyzer, parameters.analyzer_options
    return load_extension("analyzer", name, Analyzer, 2, options)


def make_foreign_analyzer(parameters: VnaParameters, deadline: RequestDeadline) -> DrivenAnalyzer:
    """Return an analyzer whose class is in another package; raises as `make_analyzer` does."""
    found = load_analyzer(parameters)
    with deadline.watched(f"{parameters.analyzer}.__init__", _usual_limit_s(parameters)):
        try:
            made = found(parameters, deadline, **parameters.analyzer_options)
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise options_refused(
                "analyzer_options", found, f"{type(error).__name__}: {error}"
            ) from error
    return ForeignAnalyzer(made, parameters, deadline)


# What the calls that return something return.
RETURNS: Mapping[str, Callable[[Any], Any]] = {
    "identify": str,
    "configure": lambda found: _checked(found, SweepSettings),
    "sweep": lambda found: _checked(found, Sweep),
    "calibration": CalibrationStatus,
    "calibration_details": dict,
}


class ForeignAnalyzer:
    """Makes the calls of `DrivenAnalyzer` on an object, and trusts no exception and no type.

    An exception that the driver does not know becomes a `VnaConnectionError`: the driver then makes
    a new link and tries again. A call that does not return is seen by `RequestDeadline.overdue`.
    """

    def __init__(
        self, analyzer: Analyzer, parameters: VnaParameters, deadline: RequestDeadline
    ) -> None:
        self._analyzer = analyzer
        self._parameters = parameters
        self._deadline = deadline
        # What its properties were after the last call.
        self.trace_duration_s: Optional[float] = None
        self.remarks: Tuple[Message, ...] = ()
        self.temperature_c: Optional[float] = None

    def __getattr__(self, name: str) -> Callable[..., Any]:
        return functools.partial(self._call, name)

    def release(self) -> None:
        self._last_call("release")

    def disconnect(self) -> None:
        self._last_call("disconnect")

    def _call(self, name: str, *arguments: Any) -> Any:
        self._deadline.check()
        try:
            with self._watched(name):
                # Only `calibration_details` may be missing.
                call: Any = getattr(self._analyzer, name, dict)
                result = RETURNS.get(name, lambda _nothing: None)(call(*arguments))
                self.trace_duration_s = self._analyzer.trace_duration_s
                self.remarks = tuple(self._analyzer.remarks)
                temperature_c = getattr(self._analyzer, "temperature_c", None)
                self.temperature_c = None if temperature_c is None else float(temperature_c)
        except Gpr20Error:
            raise
        except Exception as error:  # the class is not ours: it may raise anything
            raise VnaConnectionError(
                Message(
                    "the VNA does not answer as it should; check its power and cable",
                    details=f"{type(error).__name__}: {error}",
                )
            ) from error
        return result

    def _last_call(self, name: str) -> None:
        with self._watched(name), contextlib.suppress(Exception):
            getattr(self._analyzer, name)()

    def _watched(self, name: str) -> contextlib.AbstractContextManager:
        limit_s = _usual_limit_s(self._parameters)
        if name == "sweep":
            # A class that does not say how long it takes has the time of a request.
            duration_s, longest_s = self.trace_duration_s, self._parameters.request_limit_s()
            limit_s += self._parameters.sweep_limit_s(duration_s) if duration_s else longest_s
        return self._deadline.watched(f"{self._parameters.analyzer}.{name}", limit_s)


def _usual_limit_s(parameters: VnaParameters) -> float:
    """Return how long a call may take that measures nothing [s]."""
    steps_s = 3.0 * parameters.connect_timeout_s + 2.0 * parameters.answer_timeout_s
    return steps_s + STEP_MARGIN_S


def _checked(value: Any, kind: Type[Answer]) -> Answer:
    if not isinstance(value, kind):
        raise TypeError(f"returned {type(value).__name__}, not {kind.__name__}")
    return value


class Status(enum.Enum):
    """How a check ended."""

    PASSED = "passed"
    FAILED = "failed"
    MEASURED = "measured"  # what the instrument does, neither good nor bad
    NOT_TESTED = "not tested"


@dataclass(frozen=True)
class Result:
    """The name of a check, for programs, how it ended, and what was found."""

    check: str
    status: Status
    text: Message


def passed(found: Sequence[Result]) -> bool:
    """Return whether no check failed."""
    return bool(found) and all(one.status is not Status.FAILED for one in found)


def has_passed(folder: Path, parameters: VnaParameters) -> bool:
    """Return whether the class that the parameters name has passed, as its source is now.

    Raises:
        InvalidValueError: It cannot be loaded.
    """
    try:
        stored = json.loads((folder / FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False  # what is not there, or damaged, shows nothing
    wanted = {"format": FORMAT, "passed": True, **_subject(parameters)}
    return isinstance(stored, dict) and {key: stored.get(key) for key in wanted} == wanted


def store(folder: Path, parameters: VnaParameters, found: Sequence[Result]) -> Path:
    """Store what was found in place of what was found before.

    Raises:
        OSError: The file cannot be written.
    """
    record: Dict[str, Any] = {
        "format": FORMAT,
        **_subject(parameters),
        "passed": passed(found),
        "checked": utc_time.iso_text(time_of_day_us()),
        "software": __version__,
        "results": [(one.check, one.status.value, str(one.text)) for one in found],
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / FILE
    replace_file(path, json.dumps(record, indent=2, sort_keys=True).encode("utf-8"))
    return path


def _subject(parameters: VnaParameters) -> Dict[str, str]:
    """Return what was checked: the MS2026C, or a class as its source is."""
    if not is_extension(parameters.analyzer):
        return {"analyzer": parameters.analyzer}
    return {
        "analyzer": parameters.analyzer,
        "options": json.dumps(parameters.analyzer_options, sort_keys=True, default=str),
        "source_sha256": _source_sha256(load_analyzer(parameters)),
    }


def _source_sha256(found: type) -> str:
    """Return the checksum of the class's module, or of all modules of its package."""
    package = sys.modules[found.__module__.partition(".")[0]]
    folders = [Path(one) for one in getattr(package, "__path__", ())]
    files = sorted(file for folder in folders for file in folder.rglob("*.py"))
    if not files:
        files = [Path(str(getattr(package, "__file__", None)))]
    checksum = hashlib.sha256()
    for file in filter(Path.is_file, files):
        checksum.update(file.name.encode("utf-8") + b"\0" + file.read_bytes() + b"\0")
    return checksum.hexdigest()

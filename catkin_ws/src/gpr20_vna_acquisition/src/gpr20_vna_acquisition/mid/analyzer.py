"""What the driver needs of a network analyzer; one class implements it for each kind."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Protocol, Sequence

from gpr20_common.message import Message
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings


class Analyzer(Protocol):
    """One network analyzer.

    The driver makes one object, which remembers what it learns about the instrument over all
    links. Making one opens no link: the check before a launch makes one, too. Every method may
    raise `VnaConnectionError`; after that the link is dead, and the driver calls `disconnect` and
    `connect`. The driver limits the time of each request, retries and reconnects; an analyzer does
    not retry. One thread calls at a time. A call that does not return ends the process of the
    driver, which is started again. A class may have more: see `DrivenAnalyzer`.
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


class DrivenAnalyzer(Analyzer, Protocol):
    """An analyzer as the driver uses it: with what a class need not have."""

    @property
    def temperature_c(self) -> Optional[float]:
        """Its temperature at the last `confirm` [degC]; None if it does not say."""

    def calibration_details(self) -> Mapping[str, Any]:
        """Return what else it says of its calibration, for survey.json; values as in JSON."""

    def forget(self) -> None:
        """Forget what was learned about which queries it answers: it is set up again."""

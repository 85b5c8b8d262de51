"""The parameters of the network analyzer's driver."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, Sequence, Tuple, Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message, numeral
from gpr20_common.mid.checks import instrument_address, ipv4_address, is_extension, number_between
from gpr20_common.mid.codec import bounded
from gpr20_survey.plan.recorded_plan import ANTENNA_DELAYS_NS
from gpr20_survey.trace.sweep import (
    IF_BANDWIDTHS_HZ,
    MAX_AVERAGES,
    MAX_FREQUENCY_HZ,
    MAX_FREQUENCY_POINTS,
    MIN_FREQUENCY_HZ,
    MIN_FREQUENCY_POINTS,
    MIN_FREQUENCY_SPACING_HZ,
    OUTPUT_POWERS,
    SECONDS_PER_POINT,
    CalibrationStatus,
    SweepSettings,
    sweep_duration_s,
)
from gpr20_vna_acquisition.errors import VnaIdentityError
from gpr20_vna_acquisition.mid.block_parser import TransferFormat
from gpr20_vna_acquisition.mid.ms2026c_commands import OPTIONAL

# The analyzer of this package; any other one is a class of another package.
MS2026C = "ms2026c"
OTHER_ANALYZERS = ("gpr20_scikit_rf:ScikitRfAnalyzer", "package.module:Class")
# A sweep may take this many times its nominal duration before it counts as hanging.
SLOWEST_SWEEP_FACTOR = 10.0
# How much longer than its time limits a step may take: a server's own timeout may arrive 1 s later,
# and ending a dead link takes up to 0.5 s.
STEP_MARGIN_S = 1.5
# Range of time limits and periods [s]: a socket refuses far longer ones.
TIMES_S = (1.0e-4, 3600.0)
# Maker, model, serial number, firmware (IEEE 488.2, *IDN?).
IDENTITY_FIELDS = 4
FREQUENCIES_HZ = (1.0, 1.0e12)
LEVELS_DB = (-300.0, 100.0)


@dataclass(frozen=True)
class VnaParameters:
    """The expected instrument, its time limits, and the limits of its traces.

    Attributes:
        analyzer: The kind of analyzer: ms2026c; gpr20_scikit_rf:ScikitRfAnalyzer for those of
            other makers that the package of this name can control; or a class of your own, such
            as my_robot.my_vna:MyAnalyzer (docs/extend/analyzer.md).
        analyzer_options: Only for a class: its arguments, by name.
        address: Address of the instrument, which clients offer as the default: four numbers for
            ms2026c; for a class also a text with "::" in it, such as the name of a VISA resource.
        maker: First field of the identification.
        model: Second field of the identification, without the options after its slash.
        vxi11_port: Only for ms2026c: TCP port of the VXI-11 core channel; 0 asks the portmapper.
        connect_timeout_s: Time limit for each step of connecting [s].
        answer_timeout_s: Time limit for one command or answer [s].
        clear_on_connect: Empty the instrument's buffers on each new link, because they may
            contain the late answer to a query of the previous one.
        lock_instrument: Only for ms2026c: keep other programs from using the instrument while it is
            connected (device_lock of VXI-11), if it offers that. The front panel stays usable.
        display_settle_s: Only for ms2026c: how long after the end of a sweep its data may still
            replace older ones [s]. The first sweep after a set-up is confirmed no earlier.
        settle_s: How long a setting may take until it can be read back [s]; up to 2 s
            according to the manual of the MS20xxC.
        seconds_per_point: Duration of a sweep per point [s], at an IF bandwidth of 10 kHz, until
            it is measured; 350 us is what the robot's group states for its unit.
        sweep_timeout_s: Time limit of a sweep beyond ten times its usual duration [s].
        request_timeout_s: Time limit of a whole request with its retries, beyond ten
            times the usual duration of a sweep [s]; a link that is lost for less than this
            does not fail the request.
        attempts: Number of attempts before an action fails, not counting those without a link;
            no caller retries it.
        retry_pause_s: Pause before each retry [s].
        link_check_s: How long the instrument may be unused until its link is checked [s].
        transfer_format: Only for ms2026c: how the numbers are transferred.
        unanswered_queries: Only for ms2026c: queries that this unit never answers, as the error of
            a set-up names them; what they would show is not checked.
        min_frequency_hz: Lowest frequency of the instrument [Hz].
        max_frequency_hz: Highest frequency of the instrument [Hz].
        accepted_calibrations: Calibration statuses, on the instrument's scale, with which
            sweeps are made: 0 none, 1 high, 2 and 3 moderate, 4 low, 5 not reported.
        min_level_db: Least median magnitude of S21 without a remark [dB]. Not the maker's
            figure: well below the level of two antennas over the ground, well above that of a
            receiver with nothing connected; measure both on the robot and choose a value between.
        max_level_db: Largest magnitude of S21 without a remark [dB]; antennas and cables are
            passive, so they cannot transmit more than 0 dB.
        antenna_delay_ns: Delay of cables and antennas that the calibration does not remove
            [ns]. Traces keep it; survey.json records it, and images are made without it.
            `gpr20 delay` fits it to a survey.
    """

    analyzer: str = MS2026C
    analyzer_options: Dict[str, Any] = field(default_factory=dict, hash=False)
    address: str = "127.0.0.1"
    maker: str = "Anritsu"
    model: str = "MS2026C"
    vxi11_port: int = bounded(0, 65535, 0)
    connect_timeout_s: float = bounded(*TIMES_S, 3.0)
    answer_timeout_s: float = bounded(*TIMES_S, 5.0)
    clear_on_connect: bool = True
    lock_instrument: bool = True
    display_settle_s: float = bounded(0.0, 60.0, 1.2)
    settle_s: float = bounded(*TIMES_S, 2.0)
    seconds_per_point: float = bounded(0.0, 10.0, SECONDS_PER_POINT)
    sweep_timeout_s: float = bounded(*TIMES_S, 10.0)
    request_timeout_s: float = bounded(*TIMES_S, 40.0)
    attempts: int = bounded(1, 100, 9)
    retry_pause_s: float = bounded(0.0, 60.0, 0.5)
    link_check_s: float = bounded(*TIMES_S, 5.0)
    transfer_format: TransferFormat = TransferFormat.REAL32
    unanswered_queries: Tuple[str, ...] = ()
    min_frequency_hz: float = bounded(*FREQUENCIES_HZ, MIN_FREQUENCY_HZ)
    max_frequency_hz: float = bounded(*FREQUENCIES_HZ, MAX_FREQUENCY_HZ)
    accepted_calibrations: Tuple[CalibrationStatus, ...] = (
        CalibrationStatus.HIGH,
        CalibrationStatus.MODERATE_POWER,
        CalibrationStatus.MODERATE_TEMPERATURE,
    )
    min_level_db: float = bounded(*LEVELS_DB, -80.0)
    max_level_db: float = bounded(*LEVELS_DB, 0.0)
    antenna_delay_ns: float = bounded(*ANTENNA_DELAYS_NS, 0.0)

    def __post_init__(self) -> None:
        if is_extension(self.analyzer):
            instrument_address("address", self.address)
        else:
            _one_of("analyzer", self.analyzer, (MS2026C,), (MS2026C, *OTHER_ANALYZERS))
            ipv4_address("address", self.address)
            if self.analyzer_options:
                raise InvalidValueError(
                    Message("analyzer_options are given, but analyzer does not name their class"),
                    fault=CONFIGURATION,
                )
        for query in self.unanswered_queries:
            _one_of("unanswered_queries", query, tuple(OPTIONAL))
        lowest_hz, highest_hz = self.min_frequency_hz, FREQUENCIES_HZ[1]
        number_between("max_frequency_hz", self.max_frequency_hz, lowest_hz, highest_hz, "Hz")
        number_between("min_level_db", self.min_level_db, LEVELS_DB[0], self.max_level_db, "dB")

    def check_sweep(self, settings: SweepSettings) -> None:
        """Refuse a sweep that the instrument cannot make.

        Raises:
            InvalidValueError: A value is outside its range, or start is not below stop.
        """
        start_hz, lowest_hz = settings.start_frequency_hz, self.min_frequency_hz
        highest_hz = self.max_frequency_hz
        start, stop = Message("the start frequency"), Message("the stop frequency")
        number_between(start, start_hz, lowest_hz, highest_hz, "Hz")
        lowest_hz = start_hz + MIN_FREQUENCY_SPACING_HZ
        number_between(stop, settings.stop_frequency_hz, lowest_hz, highest_hz, "Hz")
        points, points_name = settings.points, Message("the number of frequency points")
        number_between(points_name, points, MIN_FREQUENCY_POINTS, MAX_FREQUENCY_POINTS)
        if self.analyzer == MS2026C:
            wanted, name = settings.analyzer, Message("the IF bandwidth [Hz]")
            _one_of(name, wanted.if_bandwidth_hz, (0.0, *IF_BANDWIDTHS_HZ))
            number_between(Message("the number of averages"), wanted.averages, 0, MAX_AVERAGES)
            name = Message("the output power")
            _one_of(name, wanted.output_power, ("", *OUTPUT_POWERS), OUTPUT_POWERS)

    def check_identity(self, identity: str) -> None:
        """Compare maker and model; what follows a slash in the model is an option.

        Raises:
            VnaIdentityError: They are not those of the configuration.
        """
        fields = [field.strip() for field in identity.split(",")]
        model = fields[1].split("/")[0] if len(fields) >= IDENTITY_FIELDS else ""
        if (fields[0], model) == (self.maker, self.model):
            return
        shown = "".join(
            one if one.isascii() and one.isprintable() else "?" for one in identity[:40]
        )
        raise VnaIdentityError(
            Message(
                "the VNA identifies itself as {identity}; expected {maker} {model}; check its "
                "address, or the parameters maker and model",
                identity=repr(shown),
                maker=self.maker,
                model=self.model,
                details=repr(identity[:200]),
            )
        )

    def nominal_trace_s(self, settings: SweepSettings) -> float:
        """Return how long a trace may be expected to take before it is measured [s]."""
        # It may have any that the settings leave to it.
        narrowest_hz = IF_BANDWIDTHS_HZ[0]
        return sweep_duration_s(settings, self.seconds_per_point, narrowest_hz)

    def sweep_limit_s(self, duration_s: float) -> float:
        """Return how long a sweep may take that is expected to take `duration_s` [s]."""
        return self.sweep_timeout_s + SLOWEST_SWEEP_FACTOR * duration_s

    def request_limit_s(self, duration_s: float = 0.0) -> float:
        """Return how long a request with a trace of `duration_s` may take [s]."""
        return self.request_timeout_s + SLOWEST_SWEEP_FACTOR * duration_s

    def answered_within_s(self, duration_s: float) -> float:
        """Return when such a request is answered at the latest, whatever the instrument does [s].

        The time limit of a request is checked before each step: an exchange, or connecting, which
        has three parts (portmapper, core channel, link).
        """
        longest_step_s = max(self.answer_timeout_s, 3.0 * self.connect_timeout_s) + STEP_MARGIN_S
        return self.request_limit_s(duration_s) + longest_step_s + self.retry_pause_s


def _one_of(place: Any, value: Union[str, float], allowed: Sequence, shown: Sequence = ()) -> None:
    if value in allowed:
        return
    texts = (one if isinstance(one, str) else f"{one:.12g}" for one in shown or allowed)
    raise InvalidValueError(
        Message(
            "{place} is {value}; it must be one of {allowed}",
            place=place,
            value=repr(value[:200]) if isinstance(value, str) else numeral(value, ".12g"),
            allowed=", ".join(texts),
        )
    )

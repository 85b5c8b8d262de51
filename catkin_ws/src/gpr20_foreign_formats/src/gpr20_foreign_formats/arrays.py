"""Plain arrays of any program: spectra or A-scans, with axes in the file or in one beside it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import HIGHEST_M, on_grid
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.processing.to_frequency import EVEN
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_analysis.work import Progress
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats import gprmax, merged_hdf5
from gpr20_foreign_formats.arrays_file import READERS, arrays_in
from gpr20_foreign_formats.header import refusal
from gpr20_foreign_formats.traces import unknown_zero

S21, A_SCANS, FREQUENCY, TIME, HEIGHT = "s21", "a_scans", "frequency_hz", "time_s", "height_m"
LAST = {S21: FREQUENCY, A_SCANS: TIME}
PLACES = ("rotation_deg", "y_m", "x_m")
ASSUMED = {"rotation_deg": 0.0, "y_m": 0.0}
TRACE, DELAY, SIMULATED = "trace", "delay_s", "simulated"
# Beyond these the unit is another one, such as GHz or ns.
LIMITS: Dict[str, Tuple[float, float]] = {
    FREQUENCY: (1e6, 1e12),
    TIME: (-1e-4, 1e-4),
    HEIGHT: (0.0, HIGHEST_M),
    DELAY: (-1e-5, 1e-5),
    "x_m": (-1e7, 1e7),
    "y_m": (-1e7, 1e7),
    "rotation_deg": (-360.0, 360.0),
}
KEYS = (*LAST, *LIMITS, "dims", SIMULATED)
MOST_VALUES = 1_000_000
ABSENT = Message("missing")


@dataclass
class _Arrays:
    path: Path
    names: List[str]
    given: Mapping[Any, Any]
    """What the file beside it says, by key."""

    def has(self, key: str) -> bool:
        return key in self.given or key in self.names

    def refused(self, key: str, found: object, allowed: Message) -> UnreadableFileError:
        text = Message(
            "{file}: {key} is {found}; it must be {allowed}. Correct it there or in {beside}. The "
            "file has the arrays: {names}",
            file=self.path.name,
            key=key,
            found=found if isinstance(found, Message) else str(found)[:80],
            allowed=allowed,
            beside=_beside(self.path).name,
            names=", ".join(self.names)[:400],
        )
        return refusal(text)

    def array(self, key: str, name: str, types: str, allowed: Message) -> np.ndarray:
        if name not in self.names:
            raise self.refused(key, name, allowed)
        found = arrays_in(self.path, name)[name]
        if not found.size or found.dtype.kind not in types:
            raise self.refused(key, f"{name} ({found.dtype}, {_text(found.shape)})", allowed)
        return np.squeeze(found)

    def values(self) -> Tuple[str, np.ndarray]:
        """Return s21 or a_scans, and that array."""
        kinds = [one for one in LAST if one in self.given] or [*LAST.keys() & {*self.names}]
        allowed = Message("one complex array {s21} or one real {a_scans}", s21=S21, a_scans=A_SCANS)
        if len(kinds) != 1:
            raise self.refused("/".join(LAST), ", ".join(sorted(kinds)) or ABSENT, allowed)
        name = str(self.given.get(kinds[0], kinds[0]))
        return kinds[0], self.array(kinds[0], name, "c" if kinds == [S21] else "fiu", allowed)

    def numbers(self, key: str, default: Optional[float] = None) -> np.ndarray:
        """Return the numbers of a key, which must be in its range."""
        spec = self.given.get(key, key if key in self.names else default)
        try:
            found = self._numbers(key, spec)
        except AnalysisError:
            raise
        except (TypeError, ValueError, OverflowError) as error:
            allowed = Message(
                "a number, a list, the name of a real array, array and factor, or start, step and "
                "count (at most {most})",
                most=MOST_VALUES,
            )
            raise self.refused(key, ABSENT if spec is None else spec, allowed) from error
        lowest, highest = LIMITS[key]
        # Only heights may be unknown.
        good = (found >= lowest) & (found <= highest) | ((key == HEIGHT) & np.isnan(found))
        if not good.all():
            allowed = Message("between {lowest:g} and {highest:g}", lowest=lowest, highest=highest)
            raise self.refused(key, f"{found[~good][0]:g}", allowed)
        return found

    def _numbers(self, key: str, spec: Any) -> np.ndarray:
        factor = 1.0
        if isinstance(spec, dict) and spec.keys() == {"start", "step", "count"}:
            if spec["count"] not in range(1, MOST_VALUES + 1):
                raise ValueError(spec["count"])
            spec = float(spec["start"]) + float(spec["step"]) * np.arange(int(spec["count"]))
        elif isinstance(spec, dict) and spec.keys() == {"array", "factor"}:
            spec, factor = str(spec["array"]), float(spec["factor"])
        if isinstance(spec, str) and spec in self.names:
            spec = self.array(key, spec, "fiu", Message("real numbers"))
        found = np.squeeze(np.asarray(spec, np.float64)) * factor
        single = key == DELAY and found.ndim > 0
        if spec is None or np.asarray(spec).dtype.kind == "b" or not found.size or single:
            raise ValueError(spec)
        return found

    def axis(self, key: str) -> np.ndarray:
        """Return the frequencies or times, which must ascend, times in even steps."""
        found = np.ravel(self.numbers(key))
        steps = np.diff(found)
        uneven = key == TIME and steps.size and np.ptp(steps) > EVEN * abs(steps.mean())
        if uneven or not (steps.size and steps.min() > 0.0):
            ends = {"first": found[0], "last": found[-1]}
            text = Message("{count} values from {first:g} to {last:g}", count=len(found), **ends)
            allowed = Message("two or more that ascend, times in equal steps")
            raise self.refused(key, text, allowed)
        return found

    def order(self, kind: str, shape: Sequence[int], axes: Mapping[str, np.ndarray]) -> List[str]:
        """Return what each dimension is: what its length says, or `dims` if that is ambiguous."""
        dims, last = self.given.get("dims"), LAST[kind]
        sizes = {key: len(axis) for key, axis in axes.items()}
        counts = [sizes[key] for key in PLACES if sizes[key] > 1]
        sets = [[key for key in sizes if sizes[key] > 1]]
        if len(counts) > 1 and len({*counts}) == 1:
            sets, sizes = [*sets, [TRACE, last]], {**sizes, TRACE: counts[0]}
        found = [[*one] for keys in sets for one in permutations(keys)]
        found = [one for one in found if [sizes[key] for key in one] == [*shape]]
        found = [one for one in found if dims in (None, one)]
        if len(found) != 1:
            allowed = Message(
                "in one order of {sizes}; {count} orders fit: correct the lengths, or give dims, "
                "such as [{dims}]",
                sizes=", ".join(f"{key} {size}" for key, size in sizes.items()),
                count=len(found),
                dims=", ".join(sets[-1]),
            )
            raise self.refused(kind, _text(shape), allowed)
        return found[0]


def _text(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape)) or "1"


def _beside(path: Path) -> Path:
    return path.with_suffix(".axes.yaml")


def _opened(path: Path) -> _Arrays:
    beside = _beside(path)
    try:
        given = read_yaml(beside) if beside.exists() else {}
    except YamlFileError as error:
        text = Message("{file}: {reason}", file=beside.name, reason=error.message)
        raise UnreadableFileError(text) from error
    file = _Arrays(
        path, [*arrays_in(path)], given if isinstance(given, dict) else {str(given): None}
    )
    for key in file.given:
        if key not in KEYS:
            allowed = Message("one of the keys {keys}", keys=", ".join(KEYS))
            raise file.refused(str(key)[:80], Message("unknown"), allowed)
    if file.given.get(SIMULATED, False) not in (True, False):
        raise file.refused(SIMULATED, given[SIMULATED], Message("true or false"))
    return file


def read_arrays(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    """Read spectra or A-scans; NAME.axes.yaml beside the file names its arrays, and adds axes.

    Raises:
        UnreadableFileError: The file is damaged, or an axis is missing, wrong or ambiguous.
    """
    file = _opened(path)
    kind, values = file.values()
    last = LAST[kind]
    if kind == A_SCANS and FREQUENCY in file.given:
        band = Message("left out; --band says at which frequencies spectra are taken")
        raise file.refused(FREQUENCY, file.given[FREQUENCY], band)
    axes = {key: np.ravel(file.numbers(key, ASSUMED.get(key))) for key in PLACES}
    axes[last] = file.axis(last)
    order = file.order(kind, values.shape, axes)
    values = np.moveaxis(values, order.index(last), -1)
    shape, count = values.shape[:-1], int(np.prod(values.shape[:-1]))
    order.remove(last)
    given_m = file.numbers(HEIGHT, np.nan)
    if given_m.shape not in ((), shape):
        allowed = Message("one value, or one for each trace: {shape}", shape=_text(shape))
        raise file.refused(HEIGHT, _text(given_m.shape), allowed)
    height_m = np.broadcast_to(given_m if options.height_m is None else options.height_m, shape)
    notes = [
        Message("{file} has no {key}: {value:g} is assumed", file=path.name, key=key, value=value)
        for key, value in ASSUMED.items()
        if not file.has(key)
    ]
    attributes = {ANTENNA_DELAY: float(file.numbers(DELAY))} if file.has(DELAY) else {}
    if kind == A_SCANS and not attributes:
        notes.append(unknown_zero(path.name))
    survey = on_grid(
        printable(path.name),
        _positions(axes, order, np.indices(shape).reshape(len(shape), count)),
        values.reshape(count, -1),
        height_m.ravel().tolist(),
        axes.get(FREQUENCY),
        notes,
        simulated=file.given.get(SIMULATED),
        delay_s=axes.get(TIME),
    )
    return survey.assign_attrs(attributes)


def _positions(axes: Mapping[str, np.ndarray], order: List[str], places: np.ndarray) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each trace, from its places along each dimension."""
    numbers = dict(zip(order, places))
    columns = []
    for key in PLACES:
        # In a list of traces each has its own value, if there is more than one.
        own = numbers.get(key, numbers.get(TRACE, 0) if len(axes[key]) > 1 else 0)
        columns.append(np.broadcast_to(axes[key][own], places.shape[1]))
    return np.stack(columns, axis=1) * (1.0, dataset.MM_PER_M, dataset.MM_PER_M)


def _whole(path: Path) -> Optional[Path]:
    others = (gprmax.IMPORT, merged_hdf5.IMPORT)
    if path.suffix not in READERS or not path.is_file() or any(one.whole(path) for one in others):
        return None
    try:
        names = {*arrays_in(path)}
    except (AnalysisError, OSError):
        return None  # what is damaged is not recognized
    return path if _beside(path).exists() or any({*one} <= names for one in LAST.items()) else None


IMPORT = ImportFormat(read_arrays, _whole, ("band", "height_m"))

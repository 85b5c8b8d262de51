"""The functions of the steps: those of this package, of installed packages and of a file.

An installed package offers steps as entry points of the group `gpr20_analysis.steps`. A recipe can
name only these and the steps of this package: it never makes anything be imported that was not
installed, or named on the command line.
"""

from __future__ import annotations

import enum
import hashlib
import importlib.util
import inspect
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple, get_type_hints

import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import QUALITY, SAMPLE_DIMS
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import AnalysisError, RecipeError
from gpr20_analysis.processing.antenna_step import without_antenna
from gpr20_analysis.processing.background import remove_background, subtract_coupling
from gpr20_analysis.processing.delay import remove_delay, set_time_zero, to_time
from gpr20_analysis.processing.display import apply_gain, envelope
from gpr20_analysis.processing.filters import dewow, filter_dips
from gpr20_analysis.processing.polarization import combine_polarizations, select_polarization
from gpr20_analysis.processing.robust_pca import remove_low_rank
from gpr20_analysis.processing.samples import fill_missing
from gpr20_analysis.processing.sweep import apply_window, select_band
from gpr20_analysis.processing.time_zero import correct_topography, pick_time_zero
from gpr20_analysis.processing.to_frequency import to_frequency
from gpr20_common.message import Message

SUM_DIGITS = 16
"""Digits of the SHA-256 of a step's file that a result records."""
PARAMETER_TYPES = "int, float, str, an Enum or xarray.Dataset"

FUNCTIONS: Dict[str, Callable[..., xr.Dataset]] = {
    "antenna": without_antenna,
    "coupling": subtract_coupling,
    "background": remove_background,
    "rpca": remove_low_rank,
    "fk": filter_dips,
    "dewow": dewow,
    "band": select_band,
    "window": apply_window,
    "delay": remove_delay,
    "time_zero": set_time_zero,
    "pick_time_zero": pick_time_zero,
    "topography": correct_topography,
    "fill": fill_missing,
    "combine": combine_polarizations,
    "polarization": select_polarization,
    "time": to_time,
    "frequency": to_frequency,
    "gain": apply_gain,
    "envelope": envelope,
}
"""The steps by name; the arguments after the survey are the parameters of a step."""


@dataclass(frozen=True)
class StepFunction:
    """The function of a step.

    Attributes:
        name: How recipes and the command line name it.
        call: The function: Dataset and parameters to Dataset.
        origin: Package, version and checksum; empty for a step of this package.
    """

    name: str
    call: Callable[..., xr.Dataset]
    origin: str = ""

    @property
    def parameters(self) -> Dict[str, Tuple[Any, Any]]:
        """(Type, default) of each parameter."""
        hints = get_type_hints(self.call)
        parameters = list(inspect.signature(self.call).parameters.values())[1:]
        return {one.name: (hints.get(one.name), one.default) for one in parameters}

    def apply(self, survey: xr.Dataset, **arguments: Any) -> xr.Dataset:
        """Return the Dataset after the step; attributes that a foreign step drops are kept.

        Raises:
            AnalysisError: The step cannot be applied, failed, or made no Dataset of this survey.
        """
        if not self.origin:
            return self.call(survey, **arguments)
        try:
            result = self.call(survey, **arguments)
        except AnalysisError:
            raise
        except Exception as error:  # the function is not ours: it may raise anything
            raise AnalysisError(
                Message(
                    "step '{step}' ({origin}) failed: {reason}",
                    step=self.name,
                    origin=self.origin,
                    reason=f"{type(error).__name__}: {error}",
                ),
                fault=faults.STEPS,
            ) from error
        self._check(survey, result)
        return result.assign_attrs({**survey.attrs, **result.attrs, **_kept(survey)})

    def _check(self, survey: xr.Dataset, result: object) -> None:
        if not isinstance(result, xr.Dataset):
            raise AnalysisError(
                Message(
                    "step '{step}' ({origin}) returned {type}; it must return an xarray.Dataset",
                    step=self.name,
                    origin=self.origin,
                    type=type(result).__name__,
                ),
                fault=faults.STEPS,
            )
        lost = [
            name
            for name in (*SAMPLE_DIMS, QUALITY)
            if name in survey and not (name in result and result[name].equals(survey[name]))
        ]
        lost += [
            str(name)
            for name, data in survey.data_vars.items()
            if name in result and set(result[name].dims) != set(data.dims)
        ]
        if lost:
            raise AnalysisError(
                Message(
                    "step '{step}' ({origin}) changed {names}; a step must keep positions, flags "
                    "and dimensions",
                    step=self.name,
                    origin=self.origin,
                    names=", ".join(lost),
                ),
                fault=faults.STEPS,
            )


STEPS = ExtensionPoint(
    "gpr20_analysis.steps",
    Message("the step"),
    own={name: StepFunction(name, call) for name, call in FUNCTIONS.items()},
    error=RecipeError,
    fault=faults.STEPS,
)
"""By this, other packages add steps."""


class StepLibrary:
    """Finds the functions of steps by name."""

    def __init__(self, file: Optional[Path] = None) -> None:
        """Make a library of the steps of this package and of installed packages.

        Args:
            file: Python file whose public functions are steps as well; it is run. Only a person
                may name it, on the command line.

        Raises:
            RecipeError: The file cannot be run, or has a step of a name that exists.
        """
        of_file = {} if file is None else _steps_of_file(file)
        for name in of_file:
            if name in FUNCTIONS:
                raise _exists(name, of_file[name].origin)
        self._steps = replace(STEPS, own={**STEPS.own, **of_file})

    @property
    def names(self) -> List[str]:
        """Names of all steps."""
        return self._steps.names()

    def find(self, name: str) -> StepFunction:
        """Return the function of a step.

        Raises:
            RecipeError: There is none, or its package cannot be used.
        """
        if name in self._steps.own:
            found: StepFunction = self._steps.own[name]
            return found
        added = self._steps.addition(name)
        return _checked(name, STEPS.load(added), added.origin)


def _kept(survey: xr.Dataset) -> Dict[str, Any]:
    # Whatever a step does: data stay simulated, and recorded as made by the steps before it.
    return {key: survey.attrs[key] for key in ("simulated", "processing") if key in survey.attrs}


def _exists(name: str, origin: str) -> RecipeError:
    return RecipeError(
        Message(
            "step '{step}' ({origin}) has a name that exists already; rename one of them",
            step=name,
            origin=origin,
        ),
        fault=faults.STEPS,
    )


def _steps_of_file(path: Path) -> Dict[str, StepFunction]:
    name = f"steps_of_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise RecipeError(
            Message("{path} is not a Python file (.py)", path=path), fault=faults.STEPS
        )
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except OSError:
        raise
    except Exception as error:  # the file is not ours: it may raise anything
        raise RecipeError(
            Message(
                "{path} cannot be run: {reason}",
                path=path,
                reason=f"{type(error).__name__}: {error}",
            ),
            fault=faults.STEPS,
        ) from error
    functions = {
        key: one
        for key, one in vars(module).items()
        if inspect.isfunction(one) and one.__module__ == name and not key.startswith("_")
    }
    return {key: _checked(key, one, f"{path.name}") for key, one in functions.items()}


def _checked(name: str, function: Any, origin: str) -> StepFunction:
    """Return a step that is not of this package, after a check of its parameters."""
    if not callable(function):
        raise RecipeError(
            Message("step '{step}' ({origin}) is not a function", step=name, origin=origin),
            fault=faults.STEPS,
        )
    found = StepFunction(name, function, f"{origin}, sha256 {_sum_of(function)}")
    for key, (kind, _default) in found.parameters.items():
        if kind not in (int, float, str, xr.Dataset) and not _is_enum(kind):
            raise RecipeError(
                Message(
                    "parameter '{parameter}' of step '{step}' ({origin}) must be annotated with "
                    "one of: {allowed}",
                    parameter=key,
                    step=name,
                    origin=origin,
                    allowed=PARAMETER_TYPES,
                ),
                fault=faults.STEPS,
            )
    return found


def _is_enum(kind: Any) -> bool:
    return inspect.isclass(kind) and issubclass(kind, enum.Enum)


def _sum_of(function: Callable) -> str:
    source = inspect.getsourcefile(inspect.unwrap(function))
    if source is None:
        return "-"
    return hashlib.sha256(Path(source).read_bytes()).hexdigest()[:SUM_DIGITS]

"""How the operator wants the window: language, theme, dimming; remembered over a restart."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.catalogue import Language, language_from_code
from gpr20_common.message import Message
from gpr20_operator.errors import SettingsError
from gpr20_operator.palette import Theme
from gpr20_operator.settings_file import SettingsFile, settings_writer

DIM_CHOICES_MIN = (0, 2, 5, 10)


@dataclass(frozen=True)
class WindowSettings:
    """What the operator has chosen.

    Attributes:
        language: Language of the window.
        theme: Colours of the window.
        dim_after_min: Time without a touch after which the screen is dimmed [min]; 0: never.
    """

    language: Language = Language.ENGLISH
    theme: Theme = Theme.SUN
    dim_after_min: int = 5

    @property
    def dim_after_s(self) -> Optional[float]:
        """Time without a touch after which the screen is dimmed [s]; None: never."""
        return self.dim_after_min * 60.0 if self.dim_after_min else None


def settings_from(values: Mapping[str, Any]) -> WindowSettings:
    """Return the settings of a file; what is missing has its default.

    Raises:
        SettingsError: A value is not one that this program writes.
    """
    given = {**values_of(WindowSettings()), **values}
    minutes = given["dim_after_min"]
    try:
        if isinstance(minutes, bool) or minutes not in DIM_CHOICES_MIN:
            raise ValueError("dim_after_min")
        return WindowSettings(language_from_code(given["language"]), Theme(given["theme"]), minutes)
    except ValueError as error:
        raise SettingsError(
            Message(
                "the settings of the window are damaged ({reason}); the defaults are used",
                reason=error,
            )
        ) from error


def values_of(settings: WindowSettings) -> Dict[str, Any]:
    """Return the content of the file."""
    return {
        "language": settings.language.value,
        "theme": settings.theme.value,
        "dim_after_min": settings.dim_after_min,
    }


class WindowMemory:
    """Reads the settings once and writes each change, not in the thread of the window.

    Args:
        file: The file; None: nothing is remembered.
        failed: Called if they cannot be read or written, also from another thread.

    Attributes:
        settings: The settings now.
    """

    def __init__(
        self,
        file: Optional[SettingsFile] = None,
        failed: Callable[[Message], None] = lambda _: None,
    ) -> None:
        self.settings = WindowSettings()
        self._writer = None if file is None else settings_writer(file, failed)
        if file is not None:
            try:
                self.settings = settings_from(file.read())
            except SettingsError as error:
                failed(error.message)

    def change(self, **changes: Any) -> None:
        """Change some settings, and remember them soon."""
        changed = replace(self.settings, **changes)
        if changed != self.settings and self._writer is not None:
            self._writer.put(values_of(changed))
        self.settings = changed

    def close(self, timeout_s: float) -> bool:
        """Return whether the settings are written within a time [s]."""
        return self._writer is None or self._writer.wait(timeout_s)

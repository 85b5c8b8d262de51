"""When the screen is dimmed, and which touch wakes it."""

from __future__ import annotations

from typing import Optional

from gpr20_common.low.clock import Clock


class Dimming:
    """Dims the screen some time after the last touch.

    Args:
        clock: Measures the time.
        after_s: Time after the last touch [s]; None: never.

    Attributes:
        dimmed: Whether the screen is dimmed.
    """

    def __init__(self, clock: Clock, after_s: Optional[float] = None) -> None:
        self.dimmed = False
        self._clock = clock
        self._after_s = after_s
        self._touched_s = clock.now_s()

    def set_after(self, after_s: Optional[float]) -> None:
        """Dim after another time [s] from now on; None: never."""
        self._after_s = after_s
        self.wake()

    def refresh(self, awake: bool) -> None:
        """Dim the screen when it is time.

        Args:
            awake: Whether something is shown that must be seen, such as an alarm.
        """
        if awake:
            self.wake()
        elif self._after_s is not None:
            self.dimmed = self._clock.now_s() - self._touched_s >= self._after_s

    def wake(self) -> bool:
        """Note a touch.

        Returns:
            Whether it only wakes the screen: it must have no other effect, because nobody sees
            well what it would act on. STOP always acts.
        """
        was_dimmed, self.dimmed = self.dimmed, False
        self._touched_s = self._clock.now_s()
        return was_dimmed

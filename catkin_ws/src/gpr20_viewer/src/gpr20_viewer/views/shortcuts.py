"""Connects the keys to what they do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Callable, Dict

from PyQt5.QtGui import QKeySequence
from PyQt5.QtWidgets import QShortcut

from gpr20_viewer.views.keys import KEYS

if TYPE_CHECKING:
    from gpr20_viewer.views.main_window import MainWindow


def add_shortcuts(window: MainWindow) -> None:
    """Let the keys of `KEYS` work in a window; a text that is being edited takes them first."""
    controls, desk = window.controls, window.desk
    actions: Dict[str, Callable[[], None]] = {
        "left": lambda: window.nudge(columns=-1),
        "right": lambda: window.nudge(columns=1),
        "up": lambda: window.nudge(rows=1),
        "down": lambda: window.nudge(rows=-1),
        "shallower": lambda: window.nudge(layers=-1),
        "deeper": lambda: window.nudge(layers=1),
        "more": lambda: controls.step_permittivity(1),
        "less": lambda: controls.step_permittivity(-1),
        "pick": window.pick,
        "mode": window.click_picks.toggle,
        "undo": desk.undo,
        "redo": desk.redo,
        "delete": desk.delete_selected,
        "polarization": controls.next_polarization,
        "direction": controls.next_direction,
        "background": controls.background.toggle,
        "all": window.sections.show_all,
    }
    for key in KEYS:
        for sequence in key.keys:
            shortcut = QShortcut(QKeySequence(sequence), window)
            # A held key must not pick, undo or delete again and again.
            repeats = key.action not in ("pick", "mode", "undo", "redo", "delete", "background")
            shortcut.setAutoRepeat(repeats)
            shortcut.activated.connect(actions[key.action])

"""A process that does the steps of a script, seen from the one that started it."""

from __future__ import annotations

import contextlib
import multiprocessing
import random
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Callable, Iterator, List, Optional, Sequence, Tuple

from fault_suite.facts import Facts
from fault_suite.script import Step, whole_script
from fault_suite.worker import Conduct, Event, Sent, run

fork = multiprocessing.get_context("fork")


class Child:
    """It begins at once."""

    def __init__(self, data: Path, steps: Sequence[Step], conduct: Conduct) -> None:
        self.steps = steps
        self.messages: List[Sent] = []
        self._connection, given = fork.Pipe(duplex=False)
        self._process: BaseProcess = fork.Process(
            target=run, args=(data, steps, conduct, given), daemon=True
        )
        self._process.start()
        given.close()

    def wait_for(self, number: int) -> None:
        """Return when the child begins this step, or a later one if it is passed over, or ends."""
        for event, asked, *_ in self._receive():
            if event is Event.ASKED and asked >= number:
                return

    def end(self) -> None:
        """Return when the child has ended by itself."""
        for _ in self._receive():
            pass
        self._process.join()
        self._connection.close()

    def kill(self) -> None:
        """Kill it with -9, and take what it sent before."""
        self._process.kill()
        self.end()

    def tell(self, facts: Facts, cut_s: Optional[Tuple[float, float]] = None) -> None:
        """Note what was asked and acknowledged.

        Args:
            facts: Where.
            cut_s: When a power cut began and ended [s]. Without power nobody is left to answer;
                the kernel may report the success of an fsync in the middle of which the disk went.
        """
        for event, number, begun_s, ended_s, _ in self.messages:
            if event is Event.ASKED:
                facts.ask(self.steps[number])
            elif event is Event.DONE and cut_s and begun_s < cut_s[1] and ended_s > cut_s[0]:
                continue
            elif event is Event.COMPLETE:
                facts.finished = True
            elif event is Event.DONE:
                facts.acknowledge(self.steps[number])

    @property
    def phase(self) -> str:
        """What it was doing last."""
        asked = [number for event, number, *_ in self.messages if event is Event.ASKED]
        return self.steps[asked[-1]].phase if asked else "nothing"

    def texts(self, event: Event) -> List[str]:
        """Return the texts of what it sent."""
        return [text for one, _, _, _, text in self.messages if one is event]

    def _receive(self) -> Iterator[Sent]:
        # It may end in the middle of a message.
        with contextlib.suppress(EOFError, OSError):
            while True:
                self.messages.append(self._connection.recv())
                yield self.messages[-1]


def refusal_of(data: Path) -> str:
    """Return why a whole survey cannot be stored in a new folder, without any fault; or nothing."""
    data.mkdir()
    child = Child(data, whole_script(random.Random(1)), Conduct(may_give_up=True))
    child.end()
    kinds = (Event.FAILED, Event.REFUSED, Event.ENDED)
    texts = [text for event, *_, text in child.messages if event in kinds and text]
    return texts[0] if texts else ""


def durations_s(
    make: Callable[[], Tuple[Path, Sequence[Step]]], runs: int
) -> List[Tuple[str, float]]:
    """Return, of children that nothing happens to, each phase and how long it took [s].

    Args:
        make: Makes an empty data folder and a script.
        runs: How many.
    """
    found: List[Tuple[str, float]] = []
    for _ in range(runs):
        data, steps = make()
        child = Child(data, steps, Conduct())
        child.end()
        found += [
            (steps[number].phase, ended_s - begun_s)
            for event, number, begun_s, ended_s, _ in child.messages
            if event is Event.DONE
        ]
    return found

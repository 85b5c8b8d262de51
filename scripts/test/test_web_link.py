"""The page over a link that is slow and cut: nothing old is ever shown as if it were live."""

from __future__ import annotations

import asyncio
import contextlib
import os
import random
import re
import threading
import time
from pathlib import Path
from typing import Iterator, List, NamedTuple, Optional

import pytest
from run_seed import SEED
from web_site_kit import Site, launched_site
from window_kit import Operator

from gpr20_operator.robot.condition import condition_of
from gpr20_operator.robot.snapshot import progress_of
from gpr20_survey.plan.survey_state import ENDED

MINUTES = float(os.environ.get("GPR20_LINK_MINUTES", "2"))
DELAY_S, PIECE_BYTES = 0.1, 1 << 16
OLD_S, NOTE_S = 5.0, 0.05
# From when to when a survey is stopped, the link works, and is cut [s].
SURVEY_S, UP_S, DOWN_S = (5.0, 20.0), (15.0, 30.0), (2.0, 12.0)
LOOK = """
const text = (selector) => document.querySelector(selector)?.innerText ?? "";
return [document.body.classList.contains("stale"), text("#state"), text("dl")];
"""
STORED = re.compile(r"(\d+) of \d+ traces")


class Link:
    """A port of loopback behind which the page is, later; while it is cut, nothing passes."""

    def __init__(self, port: int) -> None:
        self._target, self._loop, self._works = port, asyncio.new_event_loop(), asyncio.Event()
        self._works.set()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        listening = asyncio.start_server(self._connect, "127.0.0.1", 0)
        server = asyncio.run_coroutine_threadsafe(listening, self._loop).result()
        self.port: int = server.sockets[0].getsockname()[1]

    @property
    def is_up(self) -> bool:
        return self._works.is_set()

    def toggle(self) -> None:
        change = self._works.clear if self.is_up else self._works.set
        self._loop.call_soon_threadsafe(change)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._target)
        await asyncio.gather(self._carry(reader, far_writer), self._carry(far_reader, writer))

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError), contextlib.closing(writer):
            while piece := await reader.read(PIECE_BYTES):
                await asyncio.sleep(DELAY_S)
                await self._works.wait()
                writer.write(piece)
                await writer.drain()


class Shown(NamedTuple):
    """What is true, or what a person reads; times of time.monotonic()."""

    begin_s: float
    end_s: float
    title: str
    stored: Optional[int]


class Truth:
    """What is true at the robot, noted again and again."""

    def __init__(self, site: Site) -> None:
        self._model = site.screen.model
        self._noted: List[Shown] = []
        threading.Thread(target=self._note, daemon=True).start()

    def _note(self) -> None:
        while True:
            snapshot, now_s = self._model.snapshot(), time.monotonic()
            progress = progress_of(snapshot)
            stored = None if progress is None else progress.visited_points
            self._noted.append(Shown(now_s, now_s, str(condition_of(snapshot).title), stored))
            time.sleep(NOTE_S)

    def was_lately(self, shown: Shown) -> bool:
        """Return whether title and number that were shown have been true less than 5 s before."""
        lately = [one for one in self._noted if shown.begin_s - OLD_S <= one.begin_s <= shown.end_s]
        numbers = [one.stored for one in lately if one.stored is not None]
        known = any(one.stored is None for one in lately)
        if shown.stored is not None:
            known = bool(numbers) and min(numbers) <= shown.stored <= max(numbers)
        return known and any(shown.title.startswith(one.title) for one in lately)


def _let_begin_and_end(link: Link) -> Iterator[None]:
    """Let surveys and the link begin and end while somebody looks."""
    drawn, operator = random.Random(SEED), Operator()
    begun_s = time.monotonic()
    stop_s, change_s = float("inf"), begun_s + UP_S[0]
    while time.monotonic() < begun_s + 60.0 * MINUTES:
        now_s = time.monotonic()
        if operator.code in ENDED:
            operator.start()
            stop_s = now_s + drawn.uniform(*SURVEY_S)
        elif now_s > stop_s:
            operator.stop()
            stop_s = float("inf")
        if now_s > change_s:
            change_s = now_s + drawn.uniform(*(DOWN_S if link.is_up else UP_S))
            link.toggle()
        yield
        time.sleep(NOTE_S)


@pytest.mark.release
@pytest.mark.timeout(1200)
def test_nothing_old_is_shown_as_live_over_a_link_that_is_cut(tmp_path: Path) -> None:
    with launched_site(tmp_path, time_scale=30) as site:
        link = Link(int(site.address.rpartition(":")[2]))
        site.address = f"https://localhost:{link.port}"
        site.log_in("otto")
        truth, live, looks = Truth(site), [], 0  # type: Truth, List[Shown], int
        for _look in _let_begin_and_end(link):
            begin_s = time.monotonic()
            is_stale, title, figures = site.browser.run(LOOK)
            found = STORED.search(figures)
            looks += 1
            if not is_stale:
                stored = int(found.group(1)) if found else None
                live.append(Shown(begin_s, time.monotonic(), title, stored))
        print(f"\n{looks} moments, {len(live)} of them live")
        assert looks > len(live) > 100
        assert [one for one in live if not truth.was_lately(one)] == []

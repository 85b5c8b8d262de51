"""Comparison of every message of a survey's two recordings, where no manifest covers them."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from pathlib import Path
from typing import Dict, List, Set, Tuple

from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recording import RecordedMessage

Type = Tuple[str, str, str, bool]
# Topic, time [ns] and the first bytes of a checksum of a message.
Key = Tuple[str, int, bytes]


class RecordingComparison:
    """What the bag and the MCAP of a survey, read from their beginning to their end, contain.

    The chunks of the MCAP have checksums, those of the bag have none: a message of the bag is
    only right for certain if the MCAP has it too.
    """

    def __init__(self, folder: Path) -> None:
        """Read both.

        Raises:
            OSError: A file cannot be read.
        """
        bag = StoredBag(folder / survey_folder.BAG_FILE)
        mcap = StoredMcap(folder / survey_folder.MCAP_FILE)
        self.faults: List[Message] = []
        self.alone = 0
        """Number of messages that only one of the recordings contains."""
        self._types: Tuple[Dict[str, Set[Type]], Dict[str, Set[Type]]] = ({}, {})
        # Of each message, how many more of it the MCAP has than the bag; both are in nearly the
        # same order, so few are left at any time.
        surplus: Counter[Key] = Counter()
        for own, other in itertools.zip_longest(bag.messages(), mcap.messages()):
            for number, (message, change) in enumerate(((own, -1), (other, 1))):
                if message is not None:
                    self._note(surplus, message, change, self._types[number])
        readable = bag.path.exists() and mcap.path.exists()
        self.faults += [*bag.faults, *bag.frame_faults(), *mcap.faults, *mcap.frame_faults()]
        if readable and not self.faults:
            self._compare(surplus)

    def _note(
        self,
        surplus: Counter[Key],
        message: RecordedMessage,
        change: int,
        types: Dict[str, Set[Type]],
    ) -> None:
        own_type = (message.datatype, message.md5sum, message.definition, message.latching)
        types.setdefault(message.topic, set()).add(own_type)
        digest = hashlib.blake2b(message.data, digest_size=8).digest()
        key = (message.topic, message.time_ns, digest)
        surplus[key] += change
        if not surplus[key]:
            del surplus[key]

    def _compare(self, surplus: Counter[Key]) -> None:
        in_bag = {key[:2] for key, count in surplus.items() if count < 0}
        in_mcap = {key[:2] for key, count in surplus.items() if count > 0}
        for topic, time_ns in sorted(in_bag & in_mcap):
            self.faults.append(
                Message(
                    "the message of {topic} at {time_s:.9f} s has other content in survey.bag "
                    "than in survey.mcap",
                    topic=topic,
                    time_s=time_ns / 1e9,
                )
            )
        self.alone = sum(map(abs, surplus.values()))
        in_bag_types, in_mcap_types = self._types
        for topic in sorted(in_bag_types.keys() & in_mcap_types.keys()):
            if in_bag_types[topic] != in_mcap_types[topic]:
                self.faults.append(
                    Message(
                        "topic {topic} has another message type in survey.bag than in survey.mcap",
                        topic=topic,
                    )
                )

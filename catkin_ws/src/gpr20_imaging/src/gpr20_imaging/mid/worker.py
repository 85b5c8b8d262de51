"""The worker process of the node: answers its requests one after the other."""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection
from typing import Any, List

from gpr20_common.message import Message
from gpr20_imaging.low.analysis_worker import Analysis, message_of
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.exporting import Exporter

# Memory is given back if nobody looks at images for so long [s].
IDLE_S = 60.0


def serve(connection: Connection, analysis: Any, volumes: UsbVolumes) -> None:
    """Answer each request with stages, then result and the reason why there is none; or end.

    Args:
        connection: To the node.
        analysis: As `Analysis`.
        volumes: The sticks.
    """

    def report(stage: Message) -> None:
        connection.send((stage, None, None))

    exporter = Exporter(analysis, volumes, report)
    work = {
        "focus": analysis.focus,
        "map_hidden": analysis.map_hidden,
        "export": exporter.export,
        "make": exporter.make,
    }
    while connection.poll(IDLE_S):
        try:
            name, arguments = connection.recv()
        except EOFError:
            return
        try:
            answer = (None, work[name](*arguments), None)
        except Exception as error:  # the node reports it, and the process stays
            traceback.print_exc()
            answer = (None, None, message_of(error, f"imaging: {name}"))
        connection.send(answer)


def main(arguments: List[str]) -> None:
    """Answer the requests of the connection whose file is the argument."""
    # What ends the process cleans up like Ctrl-C.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with Connection(int(arguments[0])) as connection:
        serve(connection, Analysis(), UsbVolumes())


if __name__ == "__main__":
    main(sys.argv[1:])

"""What cannot be sent keeps nothing else from being sent."""

from gpr20_common.message import Message
from gpr20_web.low.outbox import Outbox

LIMIT_S = 10.0


def test_the_next_thing_is_sent_after_one_that_failed_as_nobody_expected(fault_log):
    sent = []

    def send(thing):
        if thing == "first":
            raise ZeroDivisionError("a fault of our own")
        sent.append(thing)

    outbox = Outbox(send, Message("not sent"), lambda _problem: None, delay_s=LIMIT_S)
    for thing in ("first", "second"):
        outbox.put(thing)
    outbox.close(LIMIT_S)
    assert sent == ["second"]
    assert "a fault of our own" in "".join(fault_log)

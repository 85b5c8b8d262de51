"""How late this computer wakes a process that does nothing else, to compare axis_motion with.

Run with: scripts/bench.sh bare_lateness
"""

from __future__ import annotations

import time

from gpr20_axis_driver.low.scheduling import realtime_scheduling

PAUSE_S = 0.0015
WAKE_UPS = 50_000
LIMIT_S = 0.0005


def main() -> None:
    print(realtime_scheduling().message)
    lateness_s = []
    due_s = time.monotonic()
    for _ in range(WAKE_UPS):
        due_s += PAUSE_S
        time.sleep(max(0.0, due_s - time.monotonic()))
        late_s = time.monotonic() - due_s
        lateness_s.append(late_s)
        if late_s > LIMIT_S:
            due_s += late_s
    lateness_s.sort()
    median_s, p99_s = lateness_s[WAKE_UPS // 2], lateness_s[WAKE_UPS * 99 // 100]
    print(
        f"{WAKE_UPS} wake-ups, late by: median {median_s * 1e6:.0f} us, 99 % {p99_s * 1e6:.0f} us, "
        f"max {lateness_s[-1] * 1e6:.0f} us; {sum(one > LIMIT_S for one in lateness_s)} beyond "
        f"{LIMIT_S * 1e6:.0f} us"
    )


if __name__ == "__main__":
    main()

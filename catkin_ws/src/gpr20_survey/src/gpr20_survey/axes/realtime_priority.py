"""The real-time priority of the processes that make the pulses of the axes."""

# Below the kernel's own real-time threads (50 and 99), above everything else.
PULSE_PRIORITY = 45

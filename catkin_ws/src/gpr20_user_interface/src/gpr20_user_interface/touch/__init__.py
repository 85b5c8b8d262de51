"""Which touches count: the guard, the hold, the lock and the dimmed screen."""

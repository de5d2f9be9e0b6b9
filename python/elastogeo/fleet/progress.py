"""A bar in a terminal; nothing in a pipe."""

from __future__ import annotations

import sys
import time

WIDTH = 30


class Progress:
    """How far a run is, on the error output."""

    def __init__(self, whole: int) -> None:
        self.whole = whole
        self.done = 0
        self.failed = 0
        self._started = self._shown = time.monotonic()
        self._screen = sys.stderr.isatty()

    @property
    def seconds(self) -> float:
        """Since the beginning."""
        return time.monotonic() - self._started

    def step(self, failed: bool) -> None:
        """One more."""
        self.done += 1
        self.failed += failed
        if self._screen and (time.monotonic() - self._shown > 0.1 or self.done == self.whole):
            self._shown = time.monotonic()
            filled = WIDTH * self.done // self.whole
            left = self.seconds * (self.whole - self.done) / self.done
            bad = f", {self.failed} failed" if self.failed else ""
            bar = f"[{'#' * filled}{'.' * (WIDTH - filled)}] {self.done}/{self.whole}{bad}, {left:.0f} s left"
            sys.stderr.write(f"\r{bar}\033[K")
            sys.stderr.flush()

    def end(self) -> None:
        """Clears the bar."""
        if self._screen:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()

"""The command `elastogeo`, in the process of the interpreter."""

import signal
import sys

from . import _native


def main() -> int:
    """Runs the command line; the exit status: 0 done, 1 the result is not to be used, 2 bad input."""
    # Ctrl-C ends the command at once, as it does that of the Rust program.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["elastogeo", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

"""The program's entry point. An interrupt gives one line instead of a traceback, even during imports."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys


def main() -> None:
    """Run the command line."""
    try:
        atexit.register(_ignore_interrupts_and_speed_up_exit)
        from eai.results.collector import reduce_garbage_collection

        reduce_garbage_collection()
        from eai.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("eai: interrupted\n")
        sys.stderr.flush()
        os._exit(130)  # skip Python's cleanup, which may fail in a half-imported library


def _ignore_interrupts_and_speed_up_exit() -> None:
    """Ignore interrupts while Python exits, to keep the exit status. Also shorten garbage collection."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.freeze()  # without this, the garbage collection at the end of `eai run` takes a second
    eval("0")  # noqa: S307 - or Python ends by the signal, where an interrupt once hit what it evaluates so


if __name__ == "__main__":
    main()

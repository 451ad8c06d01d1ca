"""The entry point: also while everything is still being imported an interrupt is no traceback."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys


def main() -> None:
    """Run the command line."""
    try:
        atexit.register(_prepare_uninterrupted_exit)
        from eai.results.collector import reduce_garbage_collection

        reduce_garbage_collection()
        from eai.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("eai: interrupted\n")
        sys.stderr.flush()
        os._exit(130)  # a half imported library might end otherwise; there is nothing to clean up yet


def _prepare_uninterrupted_exit() -> None:
    """Leave at once, with the exit status that was decided: all is done, and nothing is left to interrupt."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.freeze()  # or the collector goes through all that there is, a second after a run of models
    eval("0")  # noqa: S307 - or Python ends by the signal, where an interrupt once hit what it evaluates so


if __name__ == "__main__":
    main()

"""The entry point: also while everything is still being imported an interrupt is no traceback."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Run the command line."""
    try:
        from eai.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("eai: interrupted\n")
        sys.stderr.flush()
        os._exit(130)  # a half imported library might end otherwise; there is nothing to clean up yet


if __name__ == "__main__":
    main()

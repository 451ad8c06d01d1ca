"""The entry point: also while everything is still being imported an interrupt is no traceback."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line."""
    try:
        from eai.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("eai: interrupted\n")
        sys.exit(130)


if __name__ == "__main__":
    main()

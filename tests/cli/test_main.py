from __future__ import annotations

import signal
import subprocess
import sys

NAP = """
import sys, time
from eai import cli

@cli.app.command()
def nap() -> None:
    try:
        print("asleep", flush=True)
        time.sleep(60)
    finally:
        print("cleaned up", flush=True)

sys.argv = ["eai", "nap"]
cli.main()
"""


def test_a_request_to_terminate_is_an_ordinary_exit() -> None:
    with subprocess.Popen([sys.executable, "-c", NAP], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "asleep\n"
        process.send_signal(signal.SIGTERM)
        assert process.stdout.readline() == "cleaned up\n"
        assert process.wait(10) == 128 + signal.SIGTERM

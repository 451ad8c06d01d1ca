"""Report what modules do when they are imported: `import_watch.py FOLDER MODULE...`, in a fresh interpreter.

It prints `file:line: event` for each file, process or connection that a module below FOLDER opens during its
import, and `loaded NAME` for a slow library. An event counts for a module only if no other import lies
between. A library's own work during its import does not count.
"""

from __future__ import annotations

import importlib
import sys
from types import FrameType

SLOW = ("gymnasium", "inspect_ai", "matplotlib", "ray")
WORK = frozenset(
    {
        "open",
        "os.listdir",
        "os.mkdir",
        "os.remove",
        "os.rename",
        "os.scandir",
        "os.system",
        "socket.connect",
        "socket.getaddrinfo",
        "subprocess.Popen",
    }
)


def watch(folder: str, event: str) -> None:
    """Print an audit event if the innermost import on the stack is that of a module below the folder."""
    if event not in WORK:
        return
    frame: FrameType | None = sys._getframe(2)
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        if frame.f_code.co_filename.startswith(folder):
            print(f"{frame.f_code.co_filename}:{frame.f_lineno}: {event}")
            return
        frame = frame.f_back


if __name__ == "__main__":
    folder, names = sys.argv[1], sys.argv[2:]
    sys.addaudithook(lambda event, _: watch(folder, event))
    for name in names:
        importlib.import_module(name)
    for name in SLOW:
        if name in sys.modules:
            print(f"loaded {name}")

"""Run one task with a built-in model, which needs no key: `python example.py`."""

from __future__ import annotations

from inspect_ai import eval as run

from eai_inspect import virtualhome_action_sequencing

if __name__ == "__main__":
    (log,) = run(virtualhome_action_sequencing(), model="eai/oracle", limit=3)
    print(log.status)

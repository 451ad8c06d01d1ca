"""Task folders for Harbor, a program that runs agents in containers and scores them with a verifier.

Entry point: `export harbor` (a command).
Extra: `mcp`, only in the container image that simulates the tasks.
Page: docs/extensions/harbor/README.md.
"""

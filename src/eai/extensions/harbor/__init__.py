"""Task folders for Harbor, a program that runs agents in containers and scores them with a verifier.

Entry point: `export harbor` (a command).
Extra: `mcp`, in the image that serves a world.
Page: docs/extensions/harbor/README.md.
"""

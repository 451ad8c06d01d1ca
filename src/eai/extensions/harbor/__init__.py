"""Tasks as folders for Harbor, which runs agents in containers and has a verifier score them.

Entry point: `export harbor` (a command).
Extra: `mcp`, in the image that serves a world.
Page: docs/extensions/harbor/README.md.
"""

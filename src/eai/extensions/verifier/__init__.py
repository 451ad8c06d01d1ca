"""The verifier as tools: agents and editors check, explain and find plans, and predict effects of actions.

Entry point: `verifier_tools` (the tools of `eai serve mcp --tools`).
Extra: `mcp`.
Page: docs/extensions/verifier/README.md.
"""

"""Publish results and tasks: a board of submissions, challenge archives, and files for data set catalogues.

Entry points: `board`, `export submission`, `export results` and `export croissant` (commands).
Extra: `croissant`, for `eai export croissant`.
Page: docs/extensions/board/README.md.
"""

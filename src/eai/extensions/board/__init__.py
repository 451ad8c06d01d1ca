"""Results for others: the page of submissions, archives for a challenge, files for catalogues of data sets.

Entry points: `board`, `export submission`, `export results` and `export croissant` (commands).
Extra: `croissant`, for `eai export croissant`.
Page: docs/extensions/board/README.md.
"""

"""Derive goals from people's demonstrations, for any benchmark, and analyze how raters judge annotations.

Entry points: `data annotate` (commands) and `annotations` (a study).
Extra: `plots`, for figures of ratings.
Page: docs/extensions/annotation/README.md.
"""

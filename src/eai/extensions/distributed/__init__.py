"""Scoring of many answers by the processors of a Ray cluster, and rows of Ray Data.

Entry point: `scoring_on_ray` (`eai score --ray`).
Extra: `ray`.
Page: docs/extensions/distributed/README.md.
"""

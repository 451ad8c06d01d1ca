"""Scoring of many answers on the processors of a Ray cluster, and of rows of Ray Data.

Entry point: `scoring_on_ray` (`eai score --ray`).
Extra: `ray`.
Page: docs/extensions/distributed/README.md.
"""

"""Scoring of many answers on the processors of a Ray cluster, and scoring of rows of Ray Data or Spark.

Entry point: `scoring_on_ray` (option `--ray`).
Extra: `ray`.
Page: docs/extensions/distributed/README.md.
"""

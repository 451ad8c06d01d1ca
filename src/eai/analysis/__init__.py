"""Error analysis from verdicts."""

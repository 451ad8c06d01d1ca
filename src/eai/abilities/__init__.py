"""The paper's four abilities, one folder each, and their common verdicts, notations and explanations."""

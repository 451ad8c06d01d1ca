"""The paper's four abilities, one folder each, and their shared verdicts, notations and explanations."""

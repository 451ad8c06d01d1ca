"""The paper's four abilities, one folder each, and what they share: verdicts, notations, explanations."""

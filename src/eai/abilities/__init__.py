"""The paper's four abilities (kinds of questions), one folder each, and the code that they share."""

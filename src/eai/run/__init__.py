"""Model runs on Inspect and the built-in models; the only package that talks to a model."""

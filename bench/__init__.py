"""Programs that measure `eai`, and their results: `python -m bench` lists them."""

"""Ask models through the library Inspect, with the built-in models. No other package calls a model."""

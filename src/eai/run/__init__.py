"""Ask models through the library Inspect, and define built-in models. No other package calls a model."""

"""Which operator of a model's breaks its plans."""

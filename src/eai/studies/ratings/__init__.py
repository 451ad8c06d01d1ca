"""How good annotations are, by people who rated them."""

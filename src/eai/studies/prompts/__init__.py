"""How much depends on the way in which a question is put."""

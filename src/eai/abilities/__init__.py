"""The four abilities: for each, how an answer is parsed and scored."""

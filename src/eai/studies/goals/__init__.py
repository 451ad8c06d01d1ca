"""Goals that models find, miss and make up in goal interpretation."""

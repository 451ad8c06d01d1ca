"""How far failed answers are from right ones, and what mends them."""

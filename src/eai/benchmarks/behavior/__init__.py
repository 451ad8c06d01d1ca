"""BEHAVIOR: household chores with two hands, sliced food, dust, stains and heat."""

"""The four abilities: for each a folder that judges answers, and what others need to know of answers."""

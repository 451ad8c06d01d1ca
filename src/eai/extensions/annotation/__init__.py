"""From demonstrations to goals: what they change, what they share, what is kept of it, for any benchmark."""

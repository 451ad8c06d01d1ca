"""Words and sentences for what a task says: of facts, goals and operators, whatever the world."""

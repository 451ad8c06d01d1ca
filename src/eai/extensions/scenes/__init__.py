"""Bodies: what things look like and where they stand, to show the scenes of tasks; they decide no verdict."""

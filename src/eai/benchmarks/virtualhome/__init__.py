"""VirtualHome: a household of some 300 objects, one character, 45 actions."""

"""VirtualHome: a household of some 300 objects, one character and 45 actions."""

"""The protocol `eai-1.0.5`: what the reference package does otherwise, quirk by quirk."""

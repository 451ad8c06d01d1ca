"""Declared domains: VirtualHome, BEHAVIOR, and the conformance suite for any other."""

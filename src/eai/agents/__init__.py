"""Agents that act: observations, games, environments, sessions, and the server for external agents."""

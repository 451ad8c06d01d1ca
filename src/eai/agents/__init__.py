"""Agents that act: observations, the game, environments, sessions, and the server for agents outside."""

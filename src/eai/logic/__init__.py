"""Formulas of one logic, their concrete syntaxes and their meaning on states and traces."""

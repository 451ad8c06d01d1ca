"""Cofactors: features of tasks on which success depends, by correlation and regression."""

"""A study of features of tasks on which success depends (cofactors), with correlations and regressions."""

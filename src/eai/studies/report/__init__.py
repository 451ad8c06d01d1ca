"""Reports on runs: tables, plots and the error explorer, made from records only."""

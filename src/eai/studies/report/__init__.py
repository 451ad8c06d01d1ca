"""Reports on runs: tables, plots and the error explorer (a web page), made only from records."""

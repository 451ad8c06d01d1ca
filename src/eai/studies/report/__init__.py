"""Reports on runs: tables, plots and a web page of answers, made only from stored verdicts."""

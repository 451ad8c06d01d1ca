"""Tables, plots and the error explorer, made from records only."""

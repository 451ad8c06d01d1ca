"""Studies: each varies runs, or analyses their records, and makes tables and figures."""

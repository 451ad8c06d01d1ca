"""From counts to rates, intervals, comparisons and tables; the paper's tables as data; what plots share."""

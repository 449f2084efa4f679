"""Cases of the benchmark for asv."""

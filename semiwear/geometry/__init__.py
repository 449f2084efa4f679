"""Tooth flanks, fillets and sections; one file a kind of gear; no knowledge of load."""

"""Two flanks in mesh: placement, gap, sliding, unloaded tooth contact analysis."""

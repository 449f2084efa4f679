"""Who touches, and with what pressure."""

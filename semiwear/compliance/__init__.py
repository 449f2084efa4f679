"""What gives way besides the local contact: teeth and rims of both bodies."""

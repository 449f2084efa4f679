"""Pages of the documentation site that follow from declarations, parsers and validation data."""

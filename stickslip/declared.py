"""Types of the names in `variables`, for type checkers alone: they stand in `declared.pyi`."""

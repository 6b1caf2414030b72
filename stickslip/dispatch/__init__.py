"""Points over workers: whoever needs rows of results asks for them here."""

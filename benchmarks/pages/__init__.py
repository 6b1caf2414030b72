"""From records to tables and pictures of the docs."""

"""From records to the tables and pictures of the docs."""

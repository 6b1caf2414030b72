"""From measurements to parameters: trials, the search for a minimum, errors, and the file."""

"""The paper's Euler-Cromer scheme in lanes, which march many points at the same time."""

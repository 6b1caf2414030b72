"""The paper's Euler-Cromer scheme in lanes: many points marched side by side."""

"""From measurements to parameters: data, starts, refinement, and what is told about a fit."""

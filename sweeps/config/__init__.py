"""Configs: a YAML file or a dict in, a checked Config out, or every problem at once."""

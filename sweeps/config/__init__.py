"""Configs: from a YAML file or a dict to a checked Config, or to a list of all problems."""

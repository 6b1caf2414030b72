"""What a person sees while something takes long: how far it is, and that it is alive."""

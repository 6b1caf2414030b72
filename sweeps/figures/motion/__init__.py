"""Pictures of motions in time: courses, relative motion, phase portraits."""

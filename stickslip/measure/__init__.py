"""What is measured along an orbit, and the result row that it becomes: one copy for all methods."""

"""What is measured along an orbit, and the result row that it becomes."""

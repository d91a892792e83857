"""What scripts/words runs: texts of the project, the glossary, and rules. Python's standard library only."""

"""What `simcore doctor` looks at: each check is a function from what it needs to know to findings."""

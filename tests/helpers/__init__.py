"""What test files share: models, examples, closed forms, and ways to run, break and look at things."""

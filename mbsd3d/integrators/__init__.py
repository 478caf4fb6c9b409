"""Time integration: one file a method (`method` says what one is), and what the compiled time loops share."""

"""Solutions in closed form that only tests ask for; they share no code with what they judge."""

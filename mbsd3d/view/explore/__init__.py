"""Pages that solve: tables of a mechanism as texts for the page, and how they depend on parameters."""

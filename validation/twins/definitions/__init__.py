"""Second formulation of the same mechanism in plain numpy: joints by their definitions, equations about O."""

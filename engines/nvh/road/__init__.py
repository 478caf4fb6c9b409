"""Cars on rough roads: quarter, half and whole car, roads of ISO 8608, comfort by ISO 2631."""

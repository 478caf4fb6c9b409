"""What a run leaves: samples, reactions, certificate, loads and life of bearings."""

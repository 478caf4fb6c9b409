"""How a spatial engine falls into planes, hypothesis by hypothesis; see ``validation.reduction``."""

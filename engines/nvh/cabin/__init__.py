"""Body shell of a car as modes, and the vibration of the engine at the driver's seat."""

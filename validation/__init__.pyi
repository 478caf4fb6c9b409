from .crosscheck import cross_check as cross_check
from .engine_balance.planes.reduction import reduce_to_planes as reduce_to_planes

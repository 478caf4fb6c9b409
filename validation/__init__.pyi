from engines.balance.planes.reduction import reduce_to_planes as reduce_to_planes

from .crosscheck import cross_check as cross_check

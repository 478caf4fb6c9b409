from ..demos.discovery import discover as discover
from ..demos.form import Demo as Demo
from ..demos.form import Measured as Measured
from ..demos.form import Quantity as Quantity
from ..demos.form import Curve as Curve
from ..demos.form import Ablation as Ablation
from ..demos.form import require as require

# figures
from ..base.style import LINE as LINE
from ..base.style import SUPERSCRIPTS as SUPERSCRIPTS
from ..base.style import THIN as THIN
from ..base.style import Theme as Theme
from ..base.style import aligned as aligned
from ..base.style import dress as dress
from ..base.style import house as house
from ..base.style import new_figure as new_figure
from ..base.style import theme as theme
from ..view.scene.camera import VIEW_AXES as VIEW_AXES

# pages
from ..base.templates import HtmlPage as HtmlPage
from ..base.templates import page_template as page_template
from ..report.exhibits import inline_svg as inline_svg
from ..report.facts import digits as digits

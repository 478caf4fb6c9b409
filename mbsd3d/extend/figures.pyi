# figures
from ..base.figure import Figure as Figure
from ..base.style import LINE_WIDTH_POINTS as LINE_WIDTH_POINTS
from ..base.style import GRID_WIDTH_POINTS as GRID_WIDTH_POINTS
from ..base.style import Result as Result
from ..base.style import Theme as Theme
from ..base.style import aligned as aligned
from ..base.style import style_axes as style_axes
from ..base.style import figure_style as figure_style
from ..base.style import label_decades as label_decades
from ..base.style import label_quarter_turns as label_quarter_turns
from ..base.style import new_figure as new_figure
from ..base.style import theme as theme
from ..view.scene.camera import VIEW_AXES as VIEW_AXES

# pages
from ..base.templates import HtmlPage as HtmlPage
from ..base.templates import page_template as page_template
from ..report.exhibits import inline_svg as inline_svg
from ..base.wording import digits as digits
from ..base.wording import error_text as error_text
from ..base.wording import readable as readable
from ..base.wording import relative as relative

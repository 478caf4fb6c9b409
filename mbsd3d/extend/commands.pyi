# commands
from ..cli import main as main
from ..cli.play import port_option as port_option
from ..cli.support import Failure as Failure
from ..cli.support import Listed as Listed
from ..cli.interruption import INTERRUPT_EXIT_CODE as INTERRUPT_EXIT_CODE
from ..cli.support import can_view as can_view
from ..cli.support import keep as keep
from ..cli.support import load_system as load_system
from ..cli.support import ready_folder as ready_folder
from ..cli.support import watch as watch
from ..lazy import attach as attach

# files
from ..base.paths import as_path as as_path
from ..base.paths import package_version as package_version
from ..base.paths import read_text as read_text
from ..base.csv_files import write_table as write_table
from ..base.paths import write_atomically as write_atomically
from ..files.bundles import model_digest as model_digest

# progress, threads and processes, finished work on disk
from ..base.progress import Progress as Progress
from ..base.concurrency import on_one_thread as on_one_thread
from ..base.concurrency import one_thread as one_thread
from ..sweeps.executors import closing as closing
from ..sweeps.executors import outcomes as outcomes
from ..sweeps.store import Store as Store

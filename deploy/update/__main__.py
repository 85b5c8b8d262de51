"""The program gpr20-update; debian/rules makes one file of this folder."""

import sys

from gpr20_update.high.command import main

sys.exit(main())

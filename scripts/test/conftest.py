import sys
from pathlib import Path

# The tests import the scripts as they import each other.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

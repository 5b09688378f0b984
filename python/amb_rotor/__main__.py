"""`python3 -m amb_rotor`: the command line. People use ./amb, which sets up everything first."""
import sys

from amb_rotor.cli import main

sys.exit(main())

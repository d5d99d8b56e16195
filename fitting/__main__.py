"""`python -m fitting`: the command line of diffwhitted."""

from .command_line import main

raise SystemExit(main())

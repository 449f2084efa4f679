"""`python -m semiwear` is the command `semiwear`."""

from semiwear.cli import main

raise SystemExit(main())

"""`python -m simcore`: the same as the `simcore` command."""

from simcore.cli import main

if __name__ == "__main__":
    raise SystemExit(main())

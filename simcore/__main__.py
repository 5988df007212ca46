"""Entry point of `python -m simcore`, which runs the `simcore` command."""

from simcore.cli import main

if __name__ == "__main__":
    raise SystemExit(main())

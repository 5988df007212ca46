"""Studica's navX: `navx_maker`. Needs the extra 'navx'."""

import navx  # noqa: F401  # before the modules: an import hook loads them

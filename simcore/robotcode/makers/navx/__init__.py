"""Adapter to Studica's navX gyros; needs the extra 'navx'."""

import navx  # noqa: F401  # first, because an import hook loads the modules of this package

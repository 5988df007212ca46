"""The browser view: a field, robots, pieces and a clock on a local page, live or from a log. Needs the extra `view`."""

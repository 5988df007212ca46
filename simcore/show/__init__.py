"""Pictures, pages, the browser view and replays of runs."""

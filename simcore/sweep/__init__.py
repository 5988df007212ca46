"""Many matches: experiments, their runs on all cores or a cluster, their results, and shot tables."""

"""Many matches: experiments, their runs on all cores or a cluster, what comes of them, and tables of shots."""

"""Many matches: experiments, their runs on all cores or a cluster, and what comes of them."""

"""Sweeps of many matches: experiments, runs on all cores or a cluster, results, and shot tables."""

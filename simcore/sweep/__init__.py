"""Sweeps of many matches on all cores or on a cluster, statistics of the results, and shot tables."""

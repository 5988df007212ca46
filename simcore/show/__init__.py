"""Pages and charts of runs, the live view in a browser, and layouts for AdvantageScope and Elastic."""

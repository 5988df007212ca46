"""HTML pages, charts, the live browser view, and layouts for dashboards."""

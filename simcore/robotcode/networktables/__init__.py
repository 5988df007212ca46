"""NetworkTables: telemetry, dashboard commands, Limelights and QuestNav."""

"""NetworkTables interfaces: telemetry, dashboard commands, and the tables of Limelights and QuestNav."""

"""NetworkTables: telemetry, commands of people, Limelights and QuestNav."""

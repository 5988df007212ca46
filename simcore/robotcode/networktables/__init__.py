"""What simcore says and hears on NetworkTables: telemetry, commands of people, Limelights, QuestNav."""

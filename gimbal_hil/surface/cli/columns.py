"""The option of every command that reads tables of other people: what their columns are."""

COLUMN_PAIR = "NAME=COLUMN[:UNIT]"
COLUMN_HELP = (
    "A column of your own files and its unit, as in azimuth.position=theta:deg; -deg mirrors it; may be repeated."
)

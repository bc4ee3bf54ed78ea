"""Options of every command that reads tables of other people: what their columns are, and which rows count."""

REPAIR_HELP = "Make up rows that no joint can make from their neighbours, 2 % of a log at most, and say which."
COLUMN_PAIR = "NAME=COLUMN[@TIME][:UNIT]"
COLUMN_HELP = (
    "A column of your own files and its unit, as in azimuth.position=theta:deg; -deg mirrors it; may be repeated."
)

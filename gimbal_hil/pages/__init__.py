"""Pages: what every report is made of.

plots    figures as plotly.js takes them, and their common look
antenna  the antenna in three dimensions on a canvas
report   blocks of a page, the page itself, JUnit files

Used by everything that shows a result; knows nothing of what is shown.
"""

"""Man pages from what `--help` says."""

from __future__ import annotations

import re


def manual_page(name: str, line: str, help_text: str, version: str, date: str) -> str:
    """A page of section 1 (troff, man macros) for a command or the program; `help_text` stands as it is."""
    title = name.upper().replace(" ", "-")
    body = "\n".join(_escaped(one) for one in help_text.strip("\n").splitlines())
    return (
        f'.TH "{title}" 1 "{date}" "gimbal-hil {version}"\n'
        f".SH NAME\n{_escaped(name.replace(' ', '-'))} \\- {_escaped(line.rstrip('.'))}\n"
        f".SH DESCRIPTION\n.nf\n{body}\n.fi\n"
        ".SH EXIT STATUS\n0 good, 1 a negative result, 2 bad input, 3 safety stop, 130 interrupted.\n"
        ".SH SEE ALSO\n.BR gimbal-hil (1)\n"
    )


def _escaped(line: str) -> str:
    text = line.replace("\\", "\\e").replace("-", "\\-")
    # a line that begins so would be a request
    return re.sub(r"^([.'])", r"\\&\1", text)

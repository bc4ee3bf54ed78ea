"""Every container that is read, by what it is recognised from; those of others that are known by name and not read."""

from __future__ import annotations

from pathlib import Path

from firmware_protocol.documents import require_regular
from firmware_protocol.errors import BadInputError
from gimbal_hil.data.containers.bag import SQLITE_START, is_bag, is_mcap, read_bag, read_mcap
from gimbal_hil.data.containers.can_log import is_can_log, read_can_log
from gimbal_hil.data.containers.contents import Container, Contents, broken, let_go
from gimbal_hil.data.containers.matlab import is_matlab, read_matlab
from gimbal_hil.data.containers.mf4 import is_mdf, read_mdf
from gimbal_hil.data.containers.records import is_json, read_json
from gimbal_hil.data.containers.sheets import has_lists, is_workbook, read_lists, read_workbook
from gimbal_hil.data.containers.ulog import is_ulog, read_ulog

CONTAINERS = (
    Container("ROS bag (rosbag2 folder, .db3, .bag)", "bags", is_bag, read_bag),
    Container("MCAP", "bags", is_mcap, read_mcap),
    Container("ULog (PX4)", "ulog", is_ulog, read_ulog),
    Container("MF4, MDF", "mf4", is_mdf, read_mdf),
    Container("MATLAB .mat", "", is_matlab, read_matlab),
    Container("candump, TRC, ASC, BLF with a DBC", "dbc", is_can_log, read_can_log),
    Container("Excel workbook", "xlsx", is_workbook, read_workbook),
    Container("Parquet with lists (LeRobot)", "parquet", has_lists, read_lists),
    Container("JSON, JSON lines", "", is_json, read_json),
)
_CSV = "CSV, Parquet or one of " + ", ".join(one.name for one in CONTAINERS)
#: first bytes of files that are not read -> what they are, and what to do
_FOREIGN: tuple[tuple[bytes, str, str], ...] = (
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file", "pandas.read_hdf(...).to_csv(...), or for MATLAB save(..., '-v7')"),
    (b"TDSm", "a TDMS file of LabVIEW", "TdmsFile.read(...).as_dataframe().to_csv(...) with npTDMS"),
    (b"TLOG000", "a telemetry log of mjlib (moteus tview)", "the same as CSV or JSON lines (moteus library)"),
    (b"\xa3\x95", "a DataFlash log of ArduPilot", "mavlogdump.py --format csv --types TYPE (pymavlink)"),
    (b"ARROW1", "a Feather file (Arrow)", "pandas.read_feather(...).to_parquet(...)"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an Excel workbook of the old kind (.xls)", "the same saved as .xlsx or CSV"),
    (SQLITE_START, "a SQLite database", "the folder of the ROS 2 bag that it is part of, or its table as CSV"),
    (b"\x80\x04\x95", "a pickle of Python, which is never opened", "to_parquet(...) or to_csv(...) in pandas"),
    (b"\x80\x05\x95", "a pickle of Python, which is never opened", "to_parquet(...) or to_csv(...) in pandas"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "the file that is in it"),
    (b"Rar!", "a RAR archive", "the file that is in it"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd", "zstd -d FILE"),
    (b"\xfd7zXZ\x00", "compressed with xz", "xz -d FILE"),
    (b"BZh", "compressed with bzip2", "bunzip2 FILE"),
    (b"%PDF", "a PDF", "the numbers as CSV"),
    (b"\x89PNG", "a picture", "the numbers as CSV"),
    (b"\xff\xff\xff\xff", "a stream of Arrow", "the run folder that it is in, or the same as Parquet (pyarrow.ipc)"),
    (b"version https://git-lfs", "a pointer of Git LFS to a file elsewhere", "git lfs pull"),
    (b"<!DOCTYPE", "a web page", "the file itself: the link led to a page about it"),
    (b"<html", "a web page", "the file itself: the link led to a page about it"),
    (b"PK\x05\x06", "an empty zip archive", "the log"),
    (b"\x7fELF", "a program", "the log that it wrote"),
)
_ENOUGH = 4096


def container_of(path: Path) -> Container | None:
    """The container that a file or folder is; None for one that is none of them, such as a table of text.

    Raises BadInputError for a file of a kind that is known and not read, with what to do.
    """
    require_regular(path, _CSV)
    start = _start(path)
    found = next((one for one in CONTAINERS if one.recognised(path, start)), None)
    if found is None:
        for magic, what, remedy in _FOREIGN:
            if start.startswith(magic):
                raise BadInputError(str(path), f"is {what}, which is not read", remedy)
        if start.startswith(b"PK\x03\x04") and path.suffix.lower() == ".zip":
            raise BadInputError(str(path), "is a zip archive", "the file that is in it (unzip)")
    return found


def contents_of(path: Path) -> Contents | None:
    """What a container holds; None for a file that is none. Raises BadInputError as `container_of`, for one that is
    broken or without numbers, and for a library that is not installed.
    """
    container = container_of(path)
    if container is None:
        return None
    try:
        contents = container.read(path)
    except BadInputError:
        raise
    except Exception as error:  # what a library raises on damaged bytes stands in none of their references
        let_go(error)
        raise broken(path, container.name, error) from error
    if not contents.groups:
        raise BadInputError(str(path), f"is a {contents.kind} without a column of numbers", _CSV)
    return contents


def _start(path: Path) -> bytes:
    if path.is_dir():
        return b""
    try:
        with path.open("rb") as file:
            return file.read(_ENOUGH)
    except OSError:
        return b""

"""Read the text of a design file or of another small file; refuse folders, devices and files that are too large."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.errors import InputError, Problem

MAX_BYTES = 1 << 20


NEW_DESIGN = "; 'mbcdm init NEW.yaml' writes a file to start from"


def read_text(path: Path, kind: str = "design file", hint: str = NEW_DESIGN) -> str:
    """Text of the file; at most MAX_BYTES + 1 bytes are ever read, so that a device or pipe cannot hang or fill us.

    ``kind`` and ``hint`` say in errors what the file should be, and what helps where there is none.
    """
    try:
        if path.exists() and not path.is_file():
            raise _file_error(path, "not a regular file", remedy=f"give the path of the {kind}")
        with open(path, "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise _file_error(path, f"cannot be read: {error.strerror or error}", remedy="check the path" + hint) from None
    except ValueError as error:
        raise _file_error(path, f"cannot be read: {error}", remedy="check the path") from None
    if len(content) > MAX_BYTES:
        raise _file_error(
            path,
            "too big",
            value=f"over {MAX_BYTES} bytes",
            limit=f"{MAX_BYTES} bytes",
            remedy=f"{kind}s are about 10 kB at most; check that this is one",
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise _file_error(
            path,
            "not UTF-8 text",
            value=f"byte 0x{content[error.start]:02x}",
            line=line,
            remedy="save the file as UTF-8",
        ) from None


def _file_error(path: Path, what: str, *, value: str = "", limit: str = "", line: int = 1, remedy: str) -> InputError:
    return InputError([Problem(str(path), line, "", what, value, limit, remedy)])

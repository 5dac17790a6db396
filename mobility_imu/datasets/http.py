"""One file from an address, with pooch, checked by its checksum."""

from __future__ import annotations

import importlib
import logging
from pathlib import Path

from mobility_imu.errors import InputError

TIMEOUT_S = 60.0
CHUNK_BYTES = 1 << 16


def download(url: str, sha256: str, path: Path) -> None:
    """Download a file; nothing is there unless it arrived whole.

    Parameters
    ----------
    url : address of the file
    sha256 : checksum, 64 digits
    path : where it goes, in a folder that exists

    Raises
    ------
    InputError
        If pooch is not installed, the address cannot be reached, or the file is another one.
    """
    try:
        # By name: neither is there without the extra, nor for the type checker.
        pooch, requests = (importlib.import_module(name) for name in ("pooch", "requests"))
    except ImportError:
        raise InputError(
            "this data set is downloaded with pooch, which is not installed; "
            "pip install 'mobility-imu[fetch]'"
        ) from None
    pooch.get_logger().setLevel(logging.ERROR)
    try:
        pooch.retrieve(
            url=url,
            known_hash=f"sha256:{sha256}",
            fname=path.name,
            path=path.parent,
            downloader=_store,
        )
    except requests.exceptions.HTTPError as error:
        code = getattr(error.response, "status_code", "no answer")
        raise InputError(f"{url}: cannot be downloaded (the server answers {code})") from None
    except requests.exceptions.RequestException as error:
        raise InputError(
            f"{url}: cannot be downloaded ({type(error).__name__}); is there a network?"
        ) from None
    except ValueError:
        raise InputError(
            f"{url}: what arrived is not the file that is expected (SHA-256 {sha256}); it was cut "
            "short or changed, nothing is kept"
        ) from None


def _store(url: str, output_file: str, pooch: object) -> None:
    """Transfer a file; the connection is closed however it ends, which pooch's own does not do."""
    requests = importlib.import_module("requests")
    with (
        requests.get(url, stream=True, timeout=TIMEOUT_S) as response,
        open(output_file, "wb") as output,
    ):
        response.raise_for_status()
        for chunk in response.iter_content(CHUNK_BYTES):
            output.write(chunk)

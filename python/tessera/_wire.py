"""Calls to the coordinator: channels, status codes, retries.

The methods' messages are taken from the descriptors of the services, so that nothing is generated but messages.
"""

from __future__ import annotations

import ipaddress
import os
import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import grpc

from tessera._values import Blob
from tessera.v1 import blob_pb2, farm_pb2

# proto/wire/limits.h
MAX_MESSAGE_BYTES = 96 << 20
BLOB_CHUNK_BYTES = 1 << 20
MAX_FIND_MISSING = 10000

# Those of lib/net/channel.cpp.
_CHANNEL_OPTIONS = [
    ("grpc.max_receive_message_length", MAX_MESSAGE_BYTES),
    ("grpc.max_send_message_length", MAX_MESSAGE_BYTES),
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 5_000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 10_000),
    ("grpc.max_reconnect_backoff_ms", 800),
]


class TesseraError(Exception):
    """The reason of a failure, in a sentence for people."""


class Unreachable(TesseraError):
    """The coordinator does not answer, or not any more."""


class NotFound(TesseraError):
    """There is no such job."""


class Refused(TesseraError):
    """The coordinator will not do that: a job that is not in the state for it, or rights that are missing."""


class JobFailed(TesseraError):
    """The job ended without all of its picture."""


_TRANSIENT = {
    grpc.StatusCode.UNAVAILABLE,
    grpc.StatusCode.CANCELLED,
    grpc.StatusCode.DEADLINE_EXCEEDED,
    grpc.StatusCode.RESOURCE_EXHAUSTED,
    grpc.StatusCode.ABORTED,
    grpc.StatusCode.INTERNAL,
    grpc.StatusCode.UNKNOWN,
}
_REFUSALS = {
    grpc.StatusCode.FAILED_PRECONDITION,
    grpc.StatusCode.PERMISSION_DENIED,
    grpc.StatusCode.UNAUTHENTICATED,
}


# The stored part of a blob does not fit what is sent: the next attempt asks anew where it ends.
_MISFITS = {grpc.StatusCode.DATA_LOSS, grpc.StatusCode.OUT_OF_RANGE}
_MAX_MISFITS = 3


def _error_of(error: Any, call: str) -> TesseraError:
    text = f"{call}: {error.details()}"
    if error.code() == grpc.StatusCode.NOT_FOUND:
        return NotFound(text)
    if error.code() in _REFUSALS:
        return Refused(text)
    if error.code() in _TRANSIENT:
        return Unreachable(text)
    return TesseraError(text)


def _pieces(blob: Blob, offset: int) -> Iterator[blob_pb2.UploadRequest]:
    request = blob_pb2.UploadRequest(blob=blob.ref(), offset=offset)
    # An empty blob, or one whose last byte is stored but not verified, still takes one message.
    while True:
        request.data = blob.data[offset : offset + BLOB_CHUNK_BYTES]
        yield request
        offset += BLOB_CHUNK_BYTES
        if offset >= len(blob.data):
            return
        request = blob_pb2.UploadRequest()


def _is_loopback(address: str) -> bool:
    host = address.rsplit(":", 1)[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _open_channel(address: str, tls: str | Path | None, allow_insecure: bool) -> Any:
    if tls:
        folder = Path(tls)
        # TLS 1.3 alone, as the programs (lib/net/tls.cpp); read once, before the first connection.
        os.environ["GRPC_SSL_CIPHER_SUITES"] = "PSK-AES256-GCM-SHA384"
        credentials = grpc.ssl_channel_credentials(
            root_certificates=(folder / "ca.pem").read_bytes(),
            private_key=(folder / "key.pem").read_bytes(),
            certificate_chain=(folder / "certificate.pem").read_bytes(),
        )
        return grpc.secure_channel(address, credentials, options=_CHANNEL_OPTIONS)
    if not allow_insecure and not _is_loopback(address):
        raise Refused(
            f"{address} is not this machine, and there is no encryption on the way: give tls=DIR, or "
            "allow_insecure=True"
        )
    return grpc.insecure_channel(address, options=_CHANNEL_OPTIONS)


class Connection:
    """A channel to the coordinator. Errors that may pass are waited out for `patience` seconds."""

    def __init__(
        self, address: str, tls: str | Path | None, allow_insecure: bool, patience: float
    ) -> None:
        self.address = address
        self.patience = patience
        self._channel = _open_channel(address, tls, allow_insecure)

    def close(self) -> None:
        self._channel.close()

    def _method(self, kind: str, service: str, name: str) -> Any:
        file = farm_pb2 if service == "FarmService" else blob_pb2
        answer = getattr(file, f"{name}Response")
        return getattr(self._channel, kind)(
            f"/tessera.v1.{service}/{name}",
            request_serializer=lambda message: message.SerializeToString(),
            response_deserializer=answer.FromString,
        )

    def call(self, service: str, name: str, request: Any, timeout: float = 30) -> Any:
        """One request, one answer; tried again while the coordinator does not answer."""
        method = self._method("unary_unary", service, name)
        return self.retried(lambda: method(request, timeout=timeout), f"{name} at {self.address}")

    def upload(self, blob: Blob) -> None:
        """Sends what the coordinator lacks of the blob. While another client, or another thread, sends the same
        one, its end is waited for: patience begins anew whenever more of the blob is there."""
        misfits, stored = 0, 0

        def attempt() -> None:
            nonlocal misfits, stored
            query = blob_pb2.QueryUploadRequest(blob=blob.ref())
            answer = self._method("unary_unary", "BlobService", "QueryUpload")(query, timeout=30)
            stored = answer.stored_bytes
            if answer.complete:
                return
            try:
                self._method("stream_unary", "BlobService", "Upload")(_pieces(blob, stored), timeout=600)
            except grpc.RpcError as error:
                if error.code() == grpc.StatusCode.ALREADY_EXISTS:
                    return
                misfits += error.code() in _MISFITS
                if error.code() not in _MISFITS or misfits == _MAX_MISFITS:
                    raise
                attempt()

        self.retried(attempt, f"Upload at {self.address}", lambda: stored)

    def retried_stream(self, service: str, name: str, request: Any) -> Iterator[Any]:
        """The answers to a request that has `after`, the sequence number of the last result that is there:
        where the stream breaks, it goes on behind that, for as long as there is patience."""
        method = self._method("unary_stream", service, name)
        call = f"{name} at {self.address}"
        end, bound = time.monotonic() + self.patience, 0.1
        while True:
            answers = method(request)
            try:
                for answer in answers:
                    end, bound = time.monotonic() + self.patience, 0.1
                    if answer.results:
                        request.after = answer.results[-1].sequence
                    yield answer
                return
            except grpc.RpcError as error:
                failure = _error_of(error, call)
                if not isinstance(failure, Unreachable) or time.monotonic() >= end:
                    raise failure from error
            finally:
                answers.cancel()
            time.sleep(random.uniform(bound / 2, bound))
            bound = min(2 * bound, 1.0)

    def retried(
        self, attempt: Callable[[], Any], call: str, progress: Callable[[], int] = lambda: 0
    ) -> Any:
        """Repeats `attempt` until it succeeds, fails for good, or patience is at an end, which it has not been
        since `progress` last changed."""
        end = time.monotonic() + self.patience
        bound = 0.1
        reached = progress()
        while True:
            try:
                return attempt()
            except grpc.RpcError as error:
                failure, cause = _error_of(error, call), error
            if progress() != reached:
                reached, end = progress(), time.monotonic() + self.patience
            if not isinstance(failure, Unreachable) or time.monotonic() >= end:
                raise failure from cause
            time.sleep(random.uniform(bound / 2, bound))
            bound = min(2 * bound, 1.0)

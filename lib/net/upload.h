// Bytes on their way to the coordinator's blob store. For the few sources that include gRPC.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "tessera/v1/blob.grpc.pb.h"

namespace tessera::net {

/// A blob that is read piece by piece, each behind the one before.
struct BlobPieces {
  v1::BlobRef ref;
  std::function<absl::StatusOr<std::string>(std::uint64_t offset, std::size_t size)> read;
  v1::UploadRequest first = {};  // further fields of the first message
};

/// Sends what the coordinator at `address` has not stored of a blob; calls `sent` with the bytes of each
/// message. OK too where somebody else has sent the same bytes meanwhile. DataLoss, and OutOfRange, where
/// what was stored before did not fit: the next attempt asks anew where it ends. DeadlineExceeded after 30 s
/// without progress, Cancelled when `stop` is requested.
absl::Status upload_rest(v1::BlobService::Stub& stub, const BlobPieces& blob, const std::string& address,
                         std::stop_token stop, const std::function<void(std::uint64_t)>& sent);

}  // namespace tessera::net

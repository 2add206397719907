// One upload, chunk by chunk, whatever brings the chunks.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "store/blobs/blob_store.h"
#include "tessera/v1/blob.pb.h"

namespace tessera::server {

/// Checks and stores the chunks of one stream. What came before it goes away stays stored. Not thread-safe.
class BlobUpload {
 public:
  /// Says whether the caller may upload what the first chunk names.
  using Admit = std::function<absl::Status(const v1::UploadRequest&)>;

  explicit BlobUpload(BlobStore& blobs, Admit admit = {}) : blobs_(blobs), admit_(std::move(admit)) {}

  /// The next chunk; the first one names the blob. After an error, or once wants_more() is false, no more are
  /// taken.
  absl::Status take(const v1::UploadRequest& chunk);

  /// False when somebody else was first with the same bytes: all is well, the rest need not come.
  bool wants_more() const { return !whole_; }

  /// After the last chunk: the blob is stored and visible, or an error says what is missing.
  absl::Status finish();

  const std::string& digest() const { return digest_; }
  std::uint64_t received_bytes() const { return received_bytes_; }

 private:
  absl::Status begin(const v1::UploadRequest& chunk);

  BlobStore& blobs_;
  const Admit admit_;
  std::unique_ptr<BlobWriter> writer_;
  absl::Status verdict_;
  bool whole_ = false;
  std::string digest_;
  std::uint64_t blob_size_ = 0;
  std::uint64_t stored_bytes_ = 0;
  std::uint64_t received_bytes_ = 0;  // bytes that this stream has brought
};

}  // namespace tessera::server

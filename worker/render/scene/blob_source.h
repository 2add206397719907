// Where the bytes of a scene's blobs come from.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::render {

/// The bytes of a blob; `owner` keeps them alive (a mapped file, a shared buffer). At least 16-byte aligned.
struct BlobBytes {
  std::string_view bytes;
  std::shared_ptr<const void> owner;
};

/// Where the scene's blobs come from, by digest. May block; called from several threads.
using BlobSource = std::function<absl::StatusOr<BlobBytes>(const std::string& digest)>;

}  // namespace tessera::render

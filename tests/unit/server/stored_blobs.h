// Blobs that a test puts into a store.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "store/blobs/blob_store.h"
#include "wire/digest.h"

namespace tessera::server {

/// The scene of jobs that no worker renders.
inline constexpr char kSceneBytes[] = "a scene";

/// Stores a blob, which must succeed.
inline void store_blob(BlobStore& blobs, const std::string& bytes) {
  const auto writer = blobs.write(wire::sha256_hex(bytes), 0);
  ASSERT_TRUE(writer.ok()) << writer.status();
  EXPECT_TRUE((*writer)->append(bytes).ok() && (*writer)->finish().ok());
}

}  // namespace tessera::server

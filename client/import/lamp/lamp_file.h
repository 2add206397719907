// Photometric files that scenes name, as blobs of the scene.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/blob_collector.h"

namespace tessera::client {

/// Whether the name of a file ends as those of photometric files do: .ies or .ldt.
bool is_lamp_file(std::string_view name);

/// Takes a photometric file by reference, once it has been read: InvalidArgument with the place in it, or
/// NotFound. Appends warnings. A file that it names for the tilt of its lamps is looked for beside it, and
/// makes a copy with the factors within it.
absl::StatusOr<v1::BlobRef> add_lamp_file(const std::filesystem::path& path, const std::string& hint,
                                          BlobCollector& blobs, std::vector<std::string>& warnings);

/// Likewise for bytes.
absl::StatusOr<v1::BlobRef> add_lamp_bytes(std::string bytes, const std::string& hint, BlobCollector& blobs,
                                           std::vector<std::string>& warnings);

}  // namespace tessera::client

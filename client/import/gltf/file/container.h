// The binary container of glTF (.glb), and the names of files within scene files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::client::gltf {

/// Views into the bytes of a .glb; `binary` is empty where there is no such chunk.
struct GlbChunks {
  std::string_view json, binary;
};

bool is_glb(std::string_view bytes);

/// InvalidArgument with the offset of what is wrong: another version, lengths that do not fit, a first chunk
/// that is not JSON. Chunks of unknown types are left out.
absl::StatusOr<GlbChunks> split_glb(std::string_view bytes);

bool is_data_uri(std::string_view uri);

/// The bytes of "data:TYPE;base64,...". InvalidArgument for anything that is not that.
absl::StatusOr<std::string> decode_data_uri(std::string_view uri);

/// The file that a URI names, relative to `folder`, with %XX decoded. InvalidArgument for those with a
/// scheme, from the root, or with characters that names of files do not have.
absl::StatusOr<std::filesystem::path> file_of_uri(const std::filesystem::path& folder, std::string_view uri);

}  // namespace tessera::client::gltf

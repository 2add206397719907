#include "import/gltf/file/container.h"

#include <cstdint>

#include "absl/strings/escaping.h"
#include "import/input/concat.h"
#include "import/input/load_bytes.h"

namespace tessera::client::gltf {
namespace {

constexpr std::string_view kMagic = "glTF";
constexpr std::size_t kHeaderSize = 12, kChunkHeaderSize = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

absl::Status invalid(std::size_t offset, const std::string& what) {
  return absl::InvalidArgumentError(concat("byte ", offset, ": ", what));
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

bool is_glb(std::string_view bytes) { return bytes.starts_with(kMagic); }

absl::StatusOr<GlbChunks> split_glb(std::string_view bytes) {
  if (bytes.size() < kHeaderSize) return invalid(bytes.size(), "the header of a .glb is cut off");
  if (!is_glb(bytes)) return invalid(0, "it does not begin with \"glTF\"");
  if (const auto version = load_bytes<std::uint32_t>(bytes, 4); version != 2)
    return invalid(4, concat("version ", version, " of the container: only version 2 is read"));
  const auto length = load_bytes<std::uint32_t>(bytes, 8);
  if (length != bytes.size())
    return invalid(8, concat("the file is to have ", length, " bytes, but has ", bytes.size()));
  GlbChunks chunks;
  std::size_t offset = kHeaderSize;
  for (int index = 0; offset < bytes.size(); ++index) {
    if (bytes.size() - offset < kChunkHeaderSize) return invalid(offset, "the header of a chunk is cut off");
    const auto size = load_bytes<std::uint32_t>(bytes, offset),
               type = load_bytes<std::uint32_t>(bytes, offset + 4);
    const std::size_t begin = offset + kChunkHeaderSize;
    if (size > bytes.size() - begin)
      return invalid(offset,
                     concat("a chunk of ", size, " bytes, where ", bytes.size() - begin, " are left"));
    if (size % 4 != 0)
      return invalid(offset, concat("a chunk of ", size, " bytes, which is not a multiple of 4"));
    if (index == 0 && type != kJsonChunk) return invalid(offset, "the first chunk is not JSON");
    if (index > 0 && type == kJsonChunk) return invalid(offset, "a second chunk of JSON");
    if (index > 1 && type == kBinaryChunk)
      return invalid(offset, "a binary chunk that is not the second chunk");
    if (index == 0) chunks.json = bytes.substr(begin, size);
    if (index == 1 && type == kBinaryChunk) chunks.binary = bytes.substr(begin, size);
    offset = begin + size;
  }
  if (chunks.json.empty()) return invalid(kHeaderSize, "there is no chunk of JSON");
  return chunks;
}

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

absl::StatusOr<std::string> decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64"))
    return absl::InvalidArgumentError("a data URI that is not base64");
  const std::string_view text = uri.substr(comma + 1);
  std::string bytes;
  if (!absl::Base64Unescape({text.data(), text.size()}, &bytes))
    return absl::InvalidArgumentError("a data URI whose base64 is damaged");
  return bytes;
}

absl::StatusOr<std::filesystem::path> file_of_uri(const std::filesystem::path& folder, std::string_view uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    char c = uri[i];
    if (c == '%') {
      const bool whole = uri.size() - i > 2;
      const int high = whole ? hex_digit(uri[i + 1]) : -1, low = whole ? hex_digit(uri[i + 2]) : -1;
      if (high < 0 || low < 0) return absl::InvalidArgumentError("a '%' without two hexadecimal digits");
      c = static_cast<char>(16 * high + low);
      i += 2;
    } else if (c == ':' && name.find('/') == std::string::npos) {
      return absl::InvalidArgumentError("only files beside the scene and data URIs are read");
    }
    if (static_cast<unsigned char>(c) < 32)
      return absl::InvalidArgumentError("a control character in a name");
    name += c;
  }
  if (name.empty()) return absl::InvalidArgumentError("the name is empty");
  if (name.front() == '/') return absl::InvalidArgumentError("a name from the root of the file system");
  return folder / name;
}

}  // namespace tessera::client::gltf

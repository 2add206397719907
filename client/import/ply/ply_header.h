// The header of a PLY file: what elements follow, and how they are laid out.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::client {

enum class PlyFormat : std::uint8_t { kAscii, kBinaryLittleEndian, kBinaryBigEndian };
enum class PlyType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes of a value in the binary formats.
std::size_t byte_size(PlyType type);
bool is_integer(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType list_count_type = PlyType::kUint8;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Index of a property, or -1.
  int find(std::string_view property) const;
  /// Whether all properties are scalars, so that every element has the same size.
  bool is_fixed_size() const;
  /// The least number of bytes that one element takes in the file (lists: empty).
  std::size_t min_bytes(PlyFormat format) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::size_t data_offset = 0;  // offset of the first byte after the header
  std::uint32_t header_lines = 0;
};

/// InvalidArgument with "line N: ..." for what is not a PLY header.
absl::StatusOr<PlyHeader> read_ply_header(std::string_view bytes);

}  // namespace tessera::client

// The small files that the sample scenes beside this one refer to.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::stress {

/// Writes everything that everything.textproto names into `folder`.
void write_blobs_of_the_sample(const std::filesystem::path& folder);

void write_bytes(const std::filesystem::path& path, std::string_view bytes);
std::string read_bytes(const std::filesystem::path& path);

/// An RGB image of `width` columns, with 32-bit floats where the format (by the name's ending) has them. Half
/// floats: EXR only.
void write_image(const std::filesystem::path& path, int width, const std::vector<float>& rgb,
                 bool half = false);

/// A unit square of two triangles with normals and texture coordinates: 48 numbers of vertices from byte
/// `first_number` on.
struct BinaryFile {
  std::string bytes;
  std::size_t first_number = 0;
  std::size_t numbers = 0;  // 4 bytes each
  bool big_endian = false;
};
BinaryFile binary_ply(bool big_endian);
std::string ascii_ply();
std::string obj_square();
/// Mitsuba's serialized format, before compression; and compressed.
BinaryFile raw_serialized();
std::string compress_serialized(const std::string& raw);
/// Mitsuba's volume format, 2 x 2 x 2 samples.
BinaryFile volume_file();

}  // namespace tessera::stress

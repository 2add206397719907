// The index of a light field: `manifest.json` in the folder of the set. docs/light-field.md describes the
// file for readers that have no Tessera.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "light_field/pinhole.h"

namespace tessera::light_field {

inline constexpr int kVersion = 1;
inline constexpr const char kManifestFile[] = "manifest.json";
inline constexpr const char kDataFolder[] = "data";
/// The most views and pixels that a manifest may claim.
inline constexpr std::uint64_t kMostViews = std::uint64_t{1} << 16;
inline constexpr std::uint32_t kMostSide = std::uint32_t{1} << 15;

enum class Compression : std::uint8_t { kNone, kZip, kDwaa };
const char* word_of(Compression compression);

/// The packed bytes of one tile within its file.
struct Tile {
  std::uint64_t offset = 0, bytes = 0;
  std::uint64_t hash = 0;  // tile_hash() of them

  bool operator==(const Tile&) const = default;
};

/// One picture: a tiled OpenEXR file whose name is the SHA-256 of its bytes.
struct View {
  std::string name;  // empty: its number
  Pinhole camera;
  std::string file;  // 64 hexadecimal digits: data/FILE.exr
  std::uint64_t file_bytes = 0;
  std::vector<Tile> tiles;  // row by row from the top
};

/// Cameras on a plane whose axes are parallel: views from `first_view` on, row by row from the top.
struct CameraGrid {
  std::string name;  // "plane"; of a box "+x", "-x" ...
  std::uint32_t first_view = 0, columns = 1, rows = 1;
  double spacing_x = 0, spacing_y = 0;  // world units
  /// The plane's middle, its x to the right, y up, z into the scene; of unit length.
  Matrix4 world_from_grid{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  /// z of the second plane, (u, v), onto which windows of two-plane sets are sheared.
  double focus = 1;
};

/// How the views stand.
struct Arrangement {
  std::string kind = "free";                       // "two-plane", "sphere", "box", "free"
  std::vector<CameraGrid> grids;                   // one of "two-plane", up to six of "box"
  Imath::V3d target{0, 0, 0};                      // middle of what is seen, world space
  double radius = 0;                               // of the sphere of cameras; else 0
  Imath::V3d box_low{0, 0, 0}, box_high{0, 0, 0};  // of "box"
};

struct Provenance {
  std::string program;       // "tessera 1.2.3"
  std::string scene;         // file
  std::string scene_digest;  // SHA-256 of the Scene message with all views
  std::string integrator;
  std::uint64_t seed = 0;
  std::uint32_t samples_per_pixel = 0;
  std::string settings;              // RenderSettings that the command line gave, as protobuf text
  std::vector<std::string> defines;  // NAME=VALUE
};

struct Manifest {
  std::uint32_t width = 0, height = 0;  // of each view, pixels
  std::uint32_t tile_size = 64;         // a power of two
  bool half = true;                     // colours are 16-bit; depth is always 32-bit
  Compression compression = Compression::kZip;
  double dwa_level = 0;  // of kDwaa
  double psnr_db = 0;    // of kDwaa, what it lost; 0: not measured, or nothing lost
  double metres = 0;     // length of the world's unit; 0: it is not known
  std::string colour_space = "linear Rec.709";
  Provenance provenance;
  Arrangement arrangement;
  std::vector<View> views;

  std::uint32_t tile_columns() const { return (width + tile_size - 1) / tile_size; }
  std::uint32_t tile_rows() const { return (height + tile_size - 1) / tile_size; }
};

/// The first 64 bits of the SHA-256 of a tile's packed bytes.
std::uint64_t tile_hash(std::string_view bytes);
/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

std::string to_json(const Manifest& manifest);
/// InvalidArgument, with what is wrong and where; of another version, with both versions. Numbers of views,
/// tiles and grids fit one another in what is returned, and all cameras have inverses.
absl::StatusOr<Manifest> manifest_from_json(std::string_view json);

/// Reads the manifest of the set in `folder`. NotFound where there is none; else the errors of
/// manifest_from_json() with the file's name.
absl::StatusOr<Manifest> read_manifest(const std::string& folder);
/// data/FILE.exr of a view.
std::string data_file(const std::string& folder, const View& view);

}  // namespace tessera::light_field

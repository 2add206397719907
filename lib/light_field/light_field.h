// A light field on disk: its manifest, and pixels of its views as they are asked for.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "light_field/manifest.h"
#include "light_field/tile_pixels.h"

namespace tessera::light_field {

/// Red, green, blue, alpha.
using Rgba = float __attribute__((vector_size(16)));

/// A tile whose bytes are not those that the manifest names.
struct Damage {
  std::uint32_t view = 0, column = 0, row = 0;
  bool whole_file = false;                // the file is not there, or its header is broken
  std::uint64_t expected = 0, found = 0;  // hashes; found 0: its bytes are not there

  /// "view 3, tile 2,1: its hash is ..., not ...".
  std::string text() const;
};

/// Light that a view shows at a place: the mean of four pixels, weighted as linear interpolation does.
struct Seen {
  Rgba rgba;
  float inverse_z;  // 1 / z in camera space, 0 where nothing was met
};

/// The pixels of one view; tiles are read when they are first asked for. Thread-safe, but for release().
class ViewPixels {
 public:
  ViewPixels(const Manifest& manifest, const std::string& folder, std::uint32_t number);

  /// Whether a place lies in the picture. Pixels from the upper left corner.
  bool shows(float x, float y) const { return x >= 0 && y >= 0 && x <= width_ && y <= height_; }
  /// Reads a place that the view shows; false where its tile is damaged.
  bool look(float x, float y, Seen& seen);
  /// The inverse z alone. 0 where its tile is damaged.
  float inverse_z(float x, float y);
  /// Frees the pixels, which are read again when they are asked for.
  void release();
  /// Reads all tiles.
  void load();

  /// A pixel by its number, of a view that was loaded.
  Rgba pixel(std::size_t i) const { return rgba_[i]; }
  float inverse_z(std::size_t i) const { return inverse_z_[i]; }

  std::vector<Damage> damage() const;

 private:
  enum State : std::uint8_t { kAbsent, kThere, kDamaged };
  struct Footprint {
    std::size_t i00, i10, i01, i11;
    float u, v;
  };

  /// The four pixels about a place; false where one lies in a damaged tile.
  bool find(float x, float y, Footprint& footprint);
  float mean_inverse_z(const Footprint& at) const;
  bool ensure(std::uint32_t column, std::uint32_t row) {
    const State state = static_cast<State>(states_[row * columns_ + column].load(std::memory_order_acquire));
    return state == kThere || (state == kAbsent && read(column, row));
  }
  bool read(std::uint32_t column, std::uint32_t row);
  State read_locked(std::uint32_t column, std::uint32_t row);
  void invert_distances(std::uint32_t column, std::uint32_t row);

  const Manifest& manifest_;
  const std::string folder_;
  const std::uint32_t number_;
  const float width_, height_;
  const std::uint32_t columns_, rows_, shift_;
  mutable std::mutex mutex_;
  std::unique_ptr<std::atomic<std::uint8_t>[]> states_;
  std::unique_ptr<TileFileReader> file_;
  std::unique_ptr<Rgba[]> rgba_;
  std::unique_ptr<float[]> inverse_z_;
  std::vector<Damage> damage_;
};

class LightField {
 public:
  /// Reads the manifest of the set in `folder`; errors are those of read_manifest().
  static absl::StatusOr<std::unique_ptr<LightField>> open(const std::string& folder);

  const Manifest& manifest() const { return manifest_; }
  const std::string& folder() const { return folder_; }
  std::uint32_t view_count() const { return static_cast<std::uint32_t>(manifest_.views.size()); }
  ViewPixels& pixels(std::uint32_t view) { return *pixels_[view]; }
  const Projection& projection(std::uint32_t view) const { return projections_[view]; }
  /// The point that projections measure from, world space.
  const Imath::V3d& origin() const { return origin_; }
  /// Damaged tiles that were met so far.
  std::vector<Damage> damage() const;

 private:
  LightField(std::string folder, Manifest manifest);

  const std::string folder_;
  const Manifest manifest_;
  const Imath::V3d origin_;
  std::vector<Projection> projections_;
  std::vector<std::unique_ptr<ViewPixels>> pixels_;
};

/// Holds all bytes of a view's file against the manifest: a damage a tile, one without tiles where the file
/// as a whole is not the one that was written though its tiles are, or is not there.
std::vector<Damage> check_view(const Manifest& manifest, const std::string& folder, std::uint32_t view);

}  // namespace tessera::light_field

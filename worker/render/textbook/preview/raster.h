// A z-buffer of one bin of a film [Catmull 1974]: which primitive is seen through the samples of its pixels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/accel/ray_query.h"
#include "render/integrator/scene_tables.h"
#include "render/textbook/preview/bins.h"
#include "render/textbook/preview/clusters.h"
#include "render/textbook/preview/scan_convert.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kBinPixels = kBinSide * kBinSide;

/// From where the scene is seen.
struct View {
  const SensorRecord& sensor;  // the one that the bins were made for
  const Bins& bins;
  const std::vector<std::uint8_t>& shape_seen;
  // Places of samples in their pixels, in sub-pixels from the upper left corner.
  std::int32_t sample_x = kSubPixels / 2, sample_y = kSubPixels / 2;
};

/// Samples of a bin: numbers as in a hit; shape -1 where nothing is seen.
struct BinHits {
  alignas(64) std::int32_t shape[kBinPixels];
  alignas(64) std::int32_t primitive[kBinPixels];
  alignas(64) std::int32_t instance[kBinPixels];
  // Where rays met a shape; 0 for triangles, which the ray through the sample tells.
  alignas(64) float t[kBinPixels], u[kBinPixels], v[kBinPixels];
};

class Raster {
 public:
  Raster(const SceneTables& scene, const Clusters& clusters, const RayQuery& rays)
      : scene_(scene), clusters_(clusters), rays_(rays) {}

  /// Finds what is seen through the samples of a bin: triangles by their projections, other shapes by rays
  /// through the pixels that their boxes cover.
  void render(const View& view, int column, int row);

  /// How near the latest bin's surfaces are (nearness_of()), rows from the top; -infinity where there is
  /// nothing, infinity beyond the film.
  const float* nearness() const { return nearness_; }
  void resolve(BinHits& hits) const;

 private:
  struct Item {
    std::int32_t shape, primitive, instance;
    float t = 0, u = 0, v = 0;
  };
  /// A corner on the film: coordinates in sub-pixels from the first sample, times the depth where
  /// perspective.
  struct Corner {
    Float x, y, depth;
  };

  void begin(const View& view, int column, int row);
  void draw_triangles(const Rows& rows, std::int32_t first, int count);
  void draw_clipped(const Corner (&corners)[3], int lane, std::int32_t primitive);
  void draw(const FilmTriangle& triangle, std::int32_t primitive);
  void cover_boxes(const Rows& rows, std::int32_t first, int count);
  Mask solid(int pixel, std::int32_t primitive, Mask lanes) const;
  void cast_rays();
  void cast(int count);
  float farthest() const;

  const SceneTables& scene_;
  const Clusters& clusters_;
  const RayQuery& rays_;

  // The bin at hand.
  const View* view_ = nullptr;
  int left_ = 0, top_ = 0;  // its first pixel
  alignas(64) float nearness_[kBinPixels];
  alignas(64) std::int32_t item_[kBinPixels];  // index in items_; -1: nothing
  std::uint32_t covered_[kBinSide];            // a bit for each pixel that a box covers, by rows
  std::vector<Item> items_;
  // The shape at hand.
  std::int32_t shape_ = 0, instance_ = -1;
  bool open_somewhere_ = false;

  // Rays through pixels_, and what they meet.
  alignas(64) Lanes<std::int32_t> pixels_;
  Vec3Lanes origin_, direction_;
  Lanes<float> passed_;  // ways that they have come so far
  HitState hits_;
};

}  // namespace tessera::render::TESSERA_ISA

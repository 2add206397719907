#include "render/textbook/preview/raster.h"

#include <bit>
#include <cmath>
#include <limits>

#include "render/color/texture.h"
#include "render/sensor/sensor.h"
#include "render/textbook/preview/clip.h"
#include "render/transport/vertex/passing.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
static_assert(kBinSide == 32);  // bits of a word

/// Entries between two looks at how far the bin's farthest sample is.
constexpr std::size_t kEntriesALook = 8;

/// Surfaces less opaque than this are not there.
constexpr float kLeastAlpha = 0.5f;

TESSERA_INLINE Float apply(const float (&row)[4], Vec3 p) {
  return fma(p.x, Float(row[0]), fma(p.y, Float(row[1]), fma(p.z, Float(row[2]), Float(row[3]))));
}

TESSERA_INLINE Int nearest_int(Float a) { return to_int(floor(a + 0.5f)); }

}  // namespace

void Raster::begin(const View& view, int column, int row) {
  view_ = &view;
  left_ = column * kBinSide;
  top_ = row * kBinSide;
  items_.clear();
  const int width = view.bins.projection().width - left_, height = view.bins.projection().height - top_;
  for (int y = 0; y < kBinSide; ++y) {
    covered_[y] = 0;
    for (int x = 0; x < kBinSide; x += kWidth) {
      // Nothing is nearer than what lies beyond the film.
      const Mask beyond = y >= height ? Mask::all() : ~Mask::first(width - x);
      select(beyond, Float(kInfinity), Float(-kInfinity)).store(nearness_ + y * kBinSide + x);
      Int(-1).store(item_ + y * kBinSide + x);
    }
  }
}

void Raster::render(const View& view, int column, int row) {
  begin(view, column, row);
  float far = -kInfinity;
  std::size_t looked = 0;
  Bins::Walk walk = view.bins.walk(column, row);
  while (const BinEntry* const found = walk.next()) {
    const BinEntry& entry = *found;
    if (++looked % kEntriesALook == 0) far = farthest();
    // All others are hidden as well: they come in order [Greene et al. 1993].
    if (entry.nearness <= far) break;
    const Draw& draw = clusters_.draws()[entry.draw];
    const ShapeRecord& shape = scene_.shapes.shapes[static_cast<std::size_t>(draw.shape)];
    shape_ = draw.shape;
    instance_ = draw.instance;
    const bool triangles = shape.kind == ShapeKind::kTriangles;
    const MaterialRecord& material = scene_.materials.materials[static_cast<std::size_t>(shape.material)];
    open_somewhere_ = (shape.flags & kHasAlpha) != 0 || (material.flags & kHasOpacity) != 0;
    const Affine* const placed =
        draw.instance < 0
            ? nullptr
            : &scene_.shapes.instances[static_cast<std::size_t>(draw.instance)].render_from_instance;
    const Rows rows = rows_of(view.bins.projection(), placed, left_, top_, triangles ? kSubPixels : 1);
    const auto first = static_cast<std::int32_t>(entry.cluster) * kClusterSize;
    const int count = clusters_.primitives(draw.shape, entry.cluster);
    if (triangles) {
      draw_triangles(rows, first, count);
    } else {
      cover_boxes(rows, first, count);
    }
  }
  cast_rays();
}

float Raster::farthest() const {
  Float least(kInfinity);
  for (int i = 0; i < kBinPixels; i += kWidth) least = min(least, Float::load(nearness_ + i));
  return -reduce_max(-least);
}

void Raster::draw_triangles(const Rows& rows, std::int32_t first, int count) {
  const ShapeRecord& shape = scene_.shapes.shapes[static_cast<std::size_t>(shape_)];
  const std::uint32_t* const indices =
      scene_.shapes.triangles.data() +
      std::size_t{3} * static_cast<std::size_t>(shape.first_triangle + first);
  const auto* const vertices =
      reinterpret_cast<const float*>(scene_.shapes.vertices.data() + shape.first_vertex);
  const Projection& projection = view_->bins.projection();
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int place = select_or_zero(active, (Int::iota(i)) * 3);
    Corner corner[3];
    Mask in_front = active, somewhere = Mask::none();
    Float x[3], y[3], nearness[3];
    Float reach(0.0f);
    for (int k = 0; k < 3; ++k) {
      const Int index = bit_cast<std::int32_t>(gather(indices + k, place));
      static_assert(sizeof(Vertex) == 8 * sizeof(float));
      const Float4 p = gather4(vertices, index * 8, active);
      const Vec3 position{p.c[0], p.c[1], p.c[2]};
      corner[k] = {apply(rows.x, position), apply(rows.y, position), apply(rows.depth, position)};
      const Mask ahead = corner[k].depth >= projection.nearest;
      in_front &= ahead;
      somewhere |= active & ahead;
      const Float inverse = projection.perspective ? 1.0f / corner[k].depth : Float(1.0f);
      x[k] = corner[k].x * inverse;
      y[k] = corner[k].y * inverse;
      nearness[k] = nearness_of(projection.perspective, corner[k].depth);
      reach = max(reach, max(abs(x[k]), abs(y[k])));
    }
    const Mask fits = in_front & (reach < static_cast<float>(kGuard / 2));
    // A sample lies between the least and the largest coordinate.
    Int xs[3], ys[3];
    for (int k = 0; k < 3; ++k) {
      xs[k] = nearest_int(select_or_zero(fits, x[k])) - view_->sample_x;
      ys[k] = nearest_int(select_or_zero(fits, y[k])) - view_->sample_y;
    }
    constexpr std::int32_t kLast = (kBinSide - 1) * kSubPixels;
    const auto spans_sample = [](const Int(&c)[3]) {
      const Int low = max(min(min(c[0], c[1]), c[2]), 0), high = min(max(max(c[0], c[1]), c[2]), kLast);
      return shift_right<8>(low + (kSubPixels - 1)) <= shift_right<8>(high);
    };
    const Mask visible = fits & spans_sample(xs) & spans_sample(ys);
    if (any(visible)) {
      alignas(64) std::int32_t at[6][kWidth];
      alignas(64) float near[3][kWidth];
      for (int k = 0; k < 3; ++k) xs[k].store(at[k]), ys[k].store(at[3 + k]), nearness[k].store(near[k]);
      for (std::uint32_t bits = visible.bits(); bits != 0; bits &= bits - 1) {
        const int n = std::countr_zero(bits);
        draw({{at[0][n], at[1][n], at[2][n]},
              {at[3][n], at[4][n], at[5][n]},
              {near[0][n], near[1][n], near[2][n]}},
             first + i + n);
      }
    }
    for (std::uint32_t bits = and_not(somewhere, fits).bits(); bits != 0; bits &= bits - 1) {
      const int n = std::countr_zero(bits);
      draw_clipped(corner, n, first + i + n);
    }
  }
}

void Raster::draw_clipped(const Corner (&corners)[3], int lane, std::int32_t primitive) {
  const Projection& projection = view_->bins.projection();
  ClipPolygon polygon;
  for (const Corner& corner : corners) {
    const double x = corner.x.lane(lane), y = corner.y.lane(lane), depth = corner.depth.lane(lane);
    if (!std::isfinite(x + y + depth)) return;
    polygon.corners[polygon.size++] = {x, y, projection.perspective ? depth : 1, depth};
  }
  clip(projection.nearest, kGuard / 2, polygon);
  FilmTriangle triangle{};
  const auto put = [&](std::size_t to, const ClipCorner& corner) {
    const auto place = [&](double value, std::int32_t sample) {
      return static_cast<std::int32_t>(std::floor(value / corner.w + 0.5)) - sample;
    };
    triangle.x[to] = place(corner.x, view_->sample_x);
    triangle.y[to] = place(corner.y, view_->sample_y);
    triangle.nearness[to] = static_cast<float>(projection.perspective ? 1 / corner.depth : -corner.depth);
  };
  for (int i = 2; i < polygon.size; ++i) {
    put(0, polygon.corners[0]);
    put(1, polygon.corners[i - 1]);
    put(2, polygon.corners[i]);
    draw(triangle, primitive);
  }
}

void Raster::draw(const FilmTriangle& triangle, std::int32_t primitive) {
  const auto [least, most] = std::minmax({triangle.nearness[0], triangle.nearness[1], triangle.nearness[2]});
  bool seen = false;
  const Int item(static_cast<std::int32_t>(items_.size()));
  scan_convert(triangle, kBinSide, kBinSide, [&](const Span& span) {
    for (int x = span.first & ~(kWidth - 1); x <= span.last; x += kWidth) {
      const int pixel = span.row * kBinSide + x;
      const Mask inside = and_not(Mask::first(span.last + 1 - x), Mask::first(span.first - x));
      const Float at =
          fma(Float::iota(static_cast<float>(x)), Float(static_cast<float>(span.nearness_per_column)),
              Float(static_cast<float>(span.nearness_at_0)));
      // Slopes of slivers have no digits.
      const Float near = clamp(at, least, most);
      const Float before = Float::load(nearness_ + pixel);
      Mask nearer = inside & (near > before);
      if (open_somewhere_ && any(nearer)) nearer = solid(pixel, primitive, nearer);
      if (none(nearer)) continue;
      seen = true;
      select(nearer, near, before).store(nearness_ + pixel);
      select(nearer, item, Int::load(item_ + pixel)).store(item_ + pixel);
    }
  });
  if (seen) items_.push_back({shape_, primitive, instance_});
}

Mask Raster::solid(int pixel, std::int32_t primitive, Mask lanes) const {
  const Vec2 film{
      Float::iota(static_cast<float>(left_ + pixel % kBinSide)) +
          static_cast<float>(view_->sample_x) / kSubPixels,
      Float(static_cast<float>(top_ + pixel / kBinSide) + static_cast<float>(view_->sample_y) / kSubPixels)};
  const SensorRay ray = start_ray(view_->sensor, middle_sample(film));
  const Hit hit{Float(0.0f), Float(0.0f), Float(0.0f), Int(primitive), Int(shape_), Int(instance_)};
  const Surface surface = surface_at(scene_.shapes, hit, ray.origin, ray.direction, lanes, false);
  const ShapeRecord& shape = scene_.shapes.shapes[static_cast<std::size_t>(shape_)];
  Float alpha = opacity_of(scene_, surface.material, surface, lanes);
  if (shape.flags & kHasAlpha) {
    alpha *= shape.alpha_texture < 0
                 ? Float(shape.alpha)
                 : eval_texture_scalar(scene_.textures, shape.alpha_texture, texture_point(surface), lanes);
  }
  return lanes & (alpha >= kLeastAlpha);
}

void Raster::cover_boxes(const Rows& rows, std::int32_t first, int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const BoxesOnFilm boxes = boxes_on_film(clusters_.primitive_boxes(shape_, first + i, active), rows,
                                            view_->bins.projection(), kBinSide, kBinSide, active);
    for (std::uint32_t bits = boxes.seen.bits(); bits != 0; bits &= bits - 1) {
      const int n = std::countr_zero(bits);
      const int x0 = boxes.x0.lane(n), x1 = boxes.x1.lane(n);
      const Float nearness(boxes.nearness.lane(n));
      for (int y = boxes.y0.lane(n); y < boxes.y1.lane(n); ++y) {
        std::uint32_t may_be_seen = 0;
        for (int x = 0; x < kBinSide; x += kWidth)
          may_be_seen |= (nearness > Float::load(nearness_ + y * kBinSide + x)).bits() << x;
        const std::uint32_t columns = (x1 == kBinSide ? ~0u : (1u << x1) - 1) & ~((1u << x0) - 1);
        covered_[y] |= may_be_seen & columns;
      }
    }
  }
}

void Raster::cast_rays() {
  int count = 0;
  for (int y = 0; y < kBinSide; ++y) {
    for (std::uint32_t bits = covered_[y]; bits != 0; bits &= bits - 1)
      pixels_[count++] = y * kBinSide + std::countr_zero(bits);
  }
  static_assert(kBinPixels <= kBatch);
  if (count > 0) cast(count);
}

void Raster::cast(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Int pixel = select_or_zero(Mask::first(count - i), Int::load(pixels_ + i));
    const Int row = shift_right<5>(pixel), column = pixel - row * kBinSide;
    const auto place = [](Int n, int begin, std::int32_t sample) {
      return to_float(n + begin) + static_cast<float>(sample) / kSubPixels;
    };
    const Vec2 film{place(column, left_, view_->sample_x), place(row, top_, view_->sample_y)};
    const SensorRay ray = start_ray(view_->sensor, middle_sample(film));
    store_lanes(ray.origin, origin_, i);
    store_lanes(ray.direction, direction_, i);
    Float(0.0f).store_unaligned(passed_ + i);
  }
  // Shapes that the view does not see are passed, a few in a row at most.
  constexpr int kMostPassed = 8;
  const Projection& projection = view_->bins.projection();
  const Rows rows = rows_of(projection, nullptr, 0, 0, 1);
  for (int round = 0; round <= kMostPassed; ++round) {
    rays_.nearest(arrays_of(origin_, direction_, nullptr), count, round == 0, hits_.arrays());
    int left = 0;
    for (int i = 0; i < count; ++i) {
      const std::int32_t shape = hits_.shape[i];
      if (shape < 0) continue;
      const float t = hits_.t[i];
      if (!view_->shape_seen[static_cast<std::size_t>(shape)]) {
        // On from there; neighbours in the arrays have been looked at.
        const float on = t * (1 + 0x1p-17f);
        origin_.x[left] = origin_.x[i] + direction_.x[i] * on;
        origin_.y[left] = origin_.y[i] + direction_.y[i] * on;
        origin_.z[left] = origin_.z[i] + direction_.z[i] * on;
        direction_.x[left] = direction_.x[i];
        direction_.y[left] = direction_.y[i];
        direction_.z[left] = direction_.z[i];
        passed_[left] = passed_[i] + on;
        pixels_[left++] = pixels_[i];
        continue;
      }
      const float p[3] = {origin_.x[i] + direction_.x[i] * t, origin_.y[i] + direction_.y[i] * t,
                          origin_.z[i] + direction_.z[i] * t};
      const float depth = rows.depth[0] * p[0] + rows.depth[1] * p[1] + rows.depth[2] * p[2] + rows.depth[3];
      const float nearness = projection.perspective ? 1 / depth : -depth;
      // Triangles that have been drawn are found again as near, but for rounding.
      const float before = nearness_[pixels_[i]];
      const bool nearer = nearness - before > 1e-4f * std::abs(nearness);
      if (!(depth >= projection.nearest) || !nearer) continue;
      nearness_[pixels_[i]] = nearness;
      item_[pixels_[i]] = static_cast<std::int32_t>(items_.size());
      items_.push_back(
          {shape, hits_.primitive[i], hits_.instance[i], passed_[i] + t, hits_.u[i], hits_.v[i]});
    }
    if (left == 0) return;
    count = left;
  }
}

void Raster::resolve(BinHits& hits) const {
  for (int i = 0; i < kBinPixels; ++i) {
    const Item item = item_[i] < 0 ? Item{-1, 0, -1} : items_[static_cast<std::size_t>(item_[i])];
    hits.shape[i] = item.shape;
    hits.primitive[i] = item.primitive;
    hits.instance[i] = item.instance;
    hits.t[i] = item.t;
    hits.u[i] = item.u;
    hits.v[i] = item.v;
  }
}

}  // namespace tessera::render::TESSERA_ISA

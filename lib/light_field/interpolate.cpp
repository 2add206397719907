#include "light_field/interpolate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "light_field/grid_lookup.h"
#include "light_field/nearest_cameras.h"
#include "light_field/row_work.h"

namespace tessera::light_field {
namespace {

/// Steps from a guess of the surface to where the nearest camera sees it; for surfaces that face the cameras
/// the first one is exact.
constexpr int kDepthSteps = 4;
/// Surfaces at inverse depths that differ by this part are different ones.
constexpr float kSameSurface = 0.03f;
/// Distance, in those of the target, of what no camera ray meets.
constexpr float kFarAway = 1e4f;
/// Side of the squares of pixels that weigh the same cameras, and how many of these count.
constexpr std::uint32_t kBlock = 8;
constexpr std::size_t kCameras = 4;
/// Pixels from the edge of a view over which its weight fades.
constexpr float kFade = 8;

/// A sum of what several views see of a point.
struct Blend {
  Rgba sum{};
  float weight = 0;

  void add(const Rgba& rgba, float w) { sum += rgba * w, weight += w; }
};

class Interpolator {
 public:
  Interpolator(LightField& field, const PictureRequest& request)
      : field_(field), by_(request.by), cameras_(field) {
    for (const CameraGrid& grid : field.manifest().arrangement.grids)
      grids_.emplace_back(grid, field.origin(), request.focus.value_or(grid.focus));
    std::vector<float> distances;
    for (const View& view : field.manifest().views)
      distances.push_back(static_cast<float>((view.camera.place() - field.origin()).length()));
    std::ranges::sort(distances);
    far_ = kFarAway * std::max(distances[distances.size() / 2], 1e-6f);
  }

  LocalRay local(const Ray& ray) const {
    return {Imath::V3f(ray.origin - field_.origin()), Imath::V3f(ray.direction.normalized())};
  }

  /// Looks up by the grid that the ray crosses.
  bool look_by_grid(const LocalRay& ray, Rgba& rgba) const {
    Corners corners;
    const GridLookup* grid = nullptr;
    for (const GridLookup& each : grids_) {
      if (!each.find(ray, corners)) continue;
      grid = &each;
      break;
    }
    if (grid == nullptr) return false;
    float t = grid->at_focus(corners);
    if (by_ == Interpolation::kDepth) t = surface_by_grid(ray, corners, t);
    const Imath::V3f p = ray.at(t);
    Blend all, seen;
    for (std::size_t i = 0; i < 4; ++i) {
      Seen there;
      float w = 0;
      if (!look(corners.views[i], p, there, w)) continue;
      all.add(there.rgba, corners.weights[i]);
      if (by_ == Interpolation::kDepth)
        seen.add(there.rgba, corners.weights[i] * agreement(there.inverse_z, w));
    }
    return finish(seen.weight > 1e-3f ? seen : all, rgba);
  }

  /// Looks up by the cameras around, of those that `candidates` names.
  bool look_by_cameras(const LocalRay& ray, float guess, const std::vector<std::uint32_t>& candidates,
                       Rgba& rgba) const {
    Ranking ranked = rank(ray, ray.at(guess), candidates);
    const Imath::V3f p = ray.at(surface_by_camera(ray, ranked.views[0].second, guess));
    ranked = rank(ray, p, candidates);
    struct Weighed {
      float penalty, fade, agreement;
      Rgba rgba;
    };
    std::array<Weighed, kCameras> found;
    std::size_t count = 0;
    // Weights go to 0 at the first camera that does not count, so that pictures have no seams.
    float threshold = 0;
    for (std::size_t i = 0; i < ranked.count; ++i) {
      const auto& [penalty, view] = ranked.views[i];
      if (count == kCameras || penalty > cameras_.limit()) {
        threshold = penalty;
        break;
      }
      Seen there;
      float w = 0, edge = 0;
      if (!look(view, p, there, w, &edge)) continue;
      found[count++] = {penalty, std::min(edge / kFade, 1.0f), agreement(there.inverse_z, w), there.rgba};
    }
    if (threshold == 0 && count > 0) threshold = 1.2f * found[count - 1].penalty;
    threshold += 1e-6f;
    Blend all, seen;
    for (std::size_t i = 0; i < count; ++i) {
      const float weight =
          found[i].fade * std::max(1 - found[i].penalty / threshold, 1e-4f) / (found[i].penalty + 1e-6f);
      all.add(found[i].rgba, weight);
      seen.add(found[i].rgba, weight * found[i].agreement);
    }
    return finish(seen.weight > 1e-3f * all.weight ? seen : all, rgba);
  }

  /// Where a ray passes the middle of what is seen.
  static float middle(const LocalRay& ray) { return std::max(-ray.origin.dot(ray.direction), 1e-4f); }
  const NearestCameras& cameras() const { return cameras_; }

 private:
  /// Light that a view sees of a point; `w` is the point's z in its space, `edge` how many pixels away the
  /// view ends.
  bool look(std::uint32_t view, const Imath::V3f& p, Seen& seen, float& w, float* edge = nullptr) const {
    const Imath::V3f place = field_.projection(view).homogeneous(p);
    if (!(place.z > 0)) return false;
    w = place.z;
    const float x = place.x / w, y = place.y / w;
    ViewPixels& pixels = field_.pixels(view);
    if (!pixels.shows(x, y) || !pixels.look(x, y, seen)) return false;
    const Manifest& manifest = field_.manifest();
    if (edge != nullptr) {
      *edge = std::min(std::min(x, y), std::min(static_cast<float>(manifest.width) - x,
                                                static_cast<float>(manifest.height) - y)) +
              0.01f;
    }
    return true;
  }

  /// How much a view that sees a surface at this inverse z says of a point at the z `w`.
  float agreement(float inverse_z, float w) const {
    if (w > 0.5f * far_) return inverse_z <= 2 / far_ ? 1.0f : 0.0f;
    const float difference = std::abs(inverse_z * w - 1);
    return std::max(0.0f, 1 - difference / kSameSurface);
  }

  static bool finish(const Blend& blend, Rgba& rgba) {
    if (!(blend.weight > 0)) return false;
    rgba = blend.sum / blend.weight;
    return true;
  }

  /// The ray parameter of what the camera nearest to the ray sees where the ray meets it.
  float surface_by_grid(const LocalRay& ray, const Corners& corners, float t) const {
    ViewPixels& pixels = field_.pixels(corners.nearest);
    for (int step = 0; step < kDepthSteps; ++step) {
      const Imath::V3f place = field_.projection(corners.nearest).homogeneous(ray.at(t));
      const float x = place.x / place.z, y = place.y / place.z;
      if (!(place.z > 0) || !pixels.shows(x, y)) return t;
      const float z = 1 / std::max(pixels.inverse_z(x, y), 1 / far_);
      const float next = (z - corners.z) / corners.z_step;
      const bool is_there = std::abs(next - t) <= 1e-5f * std::abs(next);
      t = next;
      if (is_there) break;
    }
    return t;
  }

  /// The same of any camera, from a guess.
  float surface_by_camera(const LocalRay& ray, std::uint32_t view, float t) const {
    ViewPixels& pixels = field_.pixels(view);
    const Projection& projection = field_.projection(view);
    const float step = projection.rows[2][0] * ray.direction.x + projection.rows[2][1] * ray.direction.y +
                       projection.rows[2][2] * ray.direction.z;
    if (!(step > 1e-3f)) return t;
    for (int i = 0; i < kDepthSteps; ++i) {
      const Imath::V3f place = projection.homogeneous(ray.at(t));
      const float x = place.x / place.z, y = place.y / place.z;
      if (!(place.z > 0) || !pixels.shows(x, y)) return t;
      // The point of the ray at the z that the camera sees there.
      const float z = 1 / std::max(pixels.inverse_z(x, y), 1 / far_);
      const float next = std::max(t + (z - place.z) / step, 1e-4f);
      const bool is_there = std::abs(next - t) <= 1e-5f * next;
      t = next;
      if (is_there) break;
    }
    return t;
  }

  /// Cameras by their penalties for the ray that meets something at `p`, the best first.
  struct Ranking {
    std::array<std::pair<float, std::uint32_t>, NearestCameras::kCandidates> views;
    std::size_t count = 0;
  };
  Ranking rank(const LocalRay& ray, const Imath::V3f& p, const std::vector<std::uint32_t>& candidates) const {
    Ranking ranking;
    for (const std::uint32_t view : candidates)
      ranking.views[ranking.count++] = {cameras_.penalty(view, ray, p), view};
    std::sort(ranking.views.begin(), ranking.views.begin() + static_cast<std::ptrdiff_t>(ranking.count));
    return ranking;
  }

  LightField& field_;
  const Interpolation by_;
  const NearestCameras cameras_;
  std::vector<GridLookup> grids_;
  float far_ = 0;
};

bool is_ray(const Ray& ray) { return ray.direction.length2() > 0; }

/// Puts a looked-up ray into the picture; counts what there is not.
struct Tally {
  std::uint64_t rays = 0, missing = 0;

  void put(bool found, const Rgba& rgba, std::size_t pixel, Picture& picture) {
    ++rays;
    missing += found ? 0 : 1;
    picture.pixels[pixel] = found ? rgba : Rgba{};
    picture.known[pixel] = found ? 1.0f : 0.0f;
  }
};

Tally look_up_row(const Interpolator& look, const PictureRequest& request, std::uint32_t y,
                  Picture& picture) {
  std::vector<Ray> rays(request.width);
  request.rays(y, rays);
  Tally tally;
  for (std::uint32_t x = 0; x < request.width; ++x) {
    if (!is_ray(rays[x])) continue;
    Rgba rgba{};
    const bool found = look.look_by_grid(look.local(rays[x]), rgba);
    tally.put(found, rgba, std::size_t{y} * request.width + x, picture);
  }
  return tally;
}

Tally look_up_band(const Interpolator& look, const PictureRequest& request, std::uint32_t band,
                   Picture& picture) {
  const std::uint32_t y0 = band * kBlock, y1 = std::min(y0 + kBlock, request.height);
  std::vector<std::vector<Ray>> rays(y1 - y0, std::vector<Ray>(request.width));
  for (std::uint32_t y = y0; y < y1; ++y) request.rays(y, rays[y - y0]);
  Tally tally;
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t x0 = 0; x0 < request.width; x0 += kBlock) {
    const std::uint32_t x1 = std::min(x0 + kBlock, request.width);
    const Ray& central = rays[(y1 - y0) / 2][(x0 + x1) / 2];
    candidates.clear();
    for (std::uint32_t y = y0; y < y1; ++y) {
      for (std::uint32_t x = x0; x < x1; ++x) {
        const Ray& ray = rays[y - y0][x];
        if (!is_ray(ray)) continue;
        if (candidates.empty()) {
          const LocalRay first = look.local(is_ray(central) ? central : ray);
          look.cameras().candidates(first, first.at(Interpolator::middle(first)), candidates);
        }
        const LocalRay local = look.local(ray);
        Rgba rgba{};
        const bool found = look.look_by_cameras(local, Interpolator::middle(local), candidates, rgba);
        tally.put(found, rgba, std::size_t{y} * request.width + x, picture);
      }
    }
  }
  return tally;
}

}  // namespace

absl::Status check_interpolation(const Arrangement& arrangement, Interpolation by) {
  if (by == Interpolation::kLumigraph || !arrangement.grids.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("its views stand in no grid (", arrangement.kind,
                                                 "): lumigraph interpolates between such cameras"));
}

absl::StatusOr<Picture> interpolate(LightField& field, const PictureRequest& request) {
  if (absl::Status s = check_interpolation(field.manifest().arrangement, request.by); !s.ok()) return s;
  Picture picture{.width = request.width, .height = request.height, .pixels = {}, .known = {}};
  picture.pixels.resize(std::size_t{request.width} * request.height);
  picture.known.resize(picture.pixels.size());
  const Interpolator look(field, request);
  std::atomic<std::uint64_t> rays = 0, missing = 0;
  const bool by_cameras = request.by == Interpolation::kLumigraph;
  const std::uint32_t rows = by_cameras ? (request.height + kBlock - 1) / kBlock : request.height;
  for_each_row(rows, request.threads, [&](std::uint32_t row) {
    const Tally tally =
        by_cameras ? look_up_band(look, request, row, picture) : look_up_row(look, request, row, picture);
    rays += tally.rays, missing += tally.missing;
  });
  picture.rays = rays, picture.missing = missing;
  return picture;
}

}  // namespace tessera::light_field

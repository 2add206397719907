#include "light_field/focal_stack.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "light_field/row_work.h"

namespace tessera::light_field {
namespace {

/// Light that the views see of a pixel at one plane: sums over views.
struct Agreement {
  Rgba sum{};
  float squares = 0, weight = 0;

  /// The variance of colour between views; infinite where fewer than two see it.
  float variance() const {
    if (!(weight > 0)) return INFINITY;
    const Rgba mean = sum / weight;
    return std::max(0.0f, squares / weight - (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]));
  }
};

class Stack {
 public:
  Stack(LightField& field, const CameraGrid& grid, const Aperture& aperture, const FocalStackOptions& options)
      : field_(field),
        options_(options),
        width_(field.manifest().width),
        height_(field.manifest().height),
        eye_(camera_of_grid(field.manifest(), grid, aperture.x, aperture.y)),
        agreements_(std::size_t{options.planes} * width_ * height_) {}

  double inverse_distance(double plane) const {
    const double part = options_.planes > 1 ? plane / (options_.planes - 1) : 0;
    return std::lerp(1 / options_.near, 1 / options_.far, part);
  }

  void add(std::uint32_t view, float weight) {
    ViewPixels& pixels = field_.pixels(view);
    const Projection& projection = field_.projection(view);
    const Imath::V3f from = projection.homogeneous(Imath::V3f(eye_.place() - field_.origin()));
    const Imath::V3f origin = projection.homogeneous(Imath::V3f(0));
    for_each_row(height_, options_.threads, [&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < width_; ++x) {
        const Imath::V3f along =
            projection.homogeneous(Imath::V3f(eye_.direction(x + 0.5, y + 0.5))) - origin;
        for (std::uint32_t plane = 0; plane < options_.planes; ++plane) {
          // The direction's z is 1 along the grid's axis, so that the distance is the ray's parameter.
          const Imath::V3f at = from + along / static_cast<float>(inverse_distance(plane));
          Seen seen;
          if (!(at.z > 0) || !pixels.shows(at.x / at.z, at.y / at.z)) continue;
          if (!pixels.look(at.x / at.z, at.y / at.z, seen)) continue;
          Agreement& agreement = this->at(plane, x, y);
          const Rgba square = seen.rgba * seen.rgba;
          agreement.sum += weight * seen.rgba;
          agreement.squares += weight * (square[0] + square[1] + square[2]);
          agreement.weight += weight;
        }
      }
    });
    pixels.release();
  }

  FocalStack finish() const {
    FocalStack result;
    Picture& sharp = result.sharp;
    sharp.width = width_, sharp.height = height_;
    sharp.pixels.resize(std::size_t{width_} * height_);
    sharp.known.resize(sharp.pixels.size());
    sharp.rays = sharp.pixels.size();
    result.depths.resize(sharp.pixels.size());
    for_each_row(height_, options_.threads, [&](std::uint32_t y) {
      std::vector<float> costs(options_.planes);
      for (std::uint32_t x = 0; x < width_; ++x) {
        for (std::uint32_t plane = 0; plane < options_.planes; ++plane) costs[plane] = cost(plane, x, y);
        const auto best = static_cast<std::uint32_t>(std::ranges::min_element(costs) - costs.begin());
        if (!std::isfinite(costs[best])) continue;
        const Agreement& agreement = at(best, x, y);
        const std::size_t pixel = std::size_t{y} * width_ + x;
        sharp.pixels[pixel] = agreement.sum / agreement.weight;
        sharp.known[pixel] = 1;
        result.depths[pixel] = static_cast<float>(1 / inverse_distance(between(costs, best)));
      }
    });
    for (const float known : sharp.known) sharp.missing += known > 0 ? 0 : 1;
    return result;
  }

 private:
  Agreement& at(std::uint32_t plane, std::uint32_t x, std::uint32_t y) {
    return agreements_[(std::size_t{plane} * height_ + y) * width_ + x];
  }
  const Agreement& at(std::uint32_t plane, std::uint32_t x, std::uint32_t y) const {
    return agreements_[(std::size_t{plane} * height_ + y) * width_ + x];
  }

  /// The mean variance of the square of pixels around one.
  float cost(std::uint32_t plane, std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t r = options_.radius;
    if (!(at(plane, x, y).weight > 0)) return INFINITY;
    float sum = 0;
    int count = 0;
    for (std::uint32_t j = y - std::min(r, y); j <= std::min(y + r, height_ - 1); ++j) {
      for (std::uint32_t i = x - std::min(r, x); i <= std::min(x + r, width_ - 1); ++i) {
        const float variance = at(plane, i, j).variance();
        if (std::isfinite(variance)) sum += variance, ++count;
      }
    }
    return sum / static_cast<float>(count);
  }

  /// The place of the least of a parabola through three costs.
  static double between(const std::vector<float>& costs, std::uint32_t best) {
    if (best == 0 || best + 1 == costs.size()) return best;
    const double before = costs[best - 1], here = costs[best], after = costs[best + 1];
    const double bend = before - 2 * here + after;
    if (!std::isfinite(bend) || !(bend > 0)) return best;
    return best + std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
  }

  LightField& field_;
  const FocalStackOptions options_;
  const std::uint32_t width_, height_;
  const Pinhole eye_;
  std::vector<Agreement> agreements_;
};

}  // namespace

absl::StatusOr<FocalStack> focal_stack(LightField& field, const Aperture& aperture,
                                       const FocalStackOptions& options) {
  const auto grid = only_grid(field.manifest());
  if (!grid.ok()) return grid.status();
  if (!(options.near > 0) || !(options.far > options.near) || options.planes < 2) {
    return absl::InvalidArgumentError(absl::StrCat("depths are looked for on two planes or more between two ",
                                                   "distances above 0, the nearer one first"));
  }
  const auto weights = camera_weights(*grid, aperture);
  if (!weights.ok()) return weights.status();
  if (weights->size() < 2)
    return absl::InvalidArgumentError(
        "one camera alone tells nothing of depth: the aperture has to be wider");
  Stack stack(field, *grid, aperture, options);
  for (const auto& [view, weight] : *weights) stack.add(view, weight);
  return stack.finish();
}

}  // namespace tessera::light_field

#include "render/textbook/radiosity/visibility.h"

#include <algorithm>
#include <cmath>

#include "base/split_mix.h"
#include "render/integrator/stage_timer.h"
#include "render/shape/error_bound.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// `p` off its surface by the roundings of a float that a point of it may have in render space. Twice the
/// renderer's bound, for here points are interpolated within parts of triangles.
Vec off_surface(const Vec& p, const Vec& normal) {
  const double extent = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
  const double along = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
  return p + normal * (2 * double{kPositionError} * extent * along);
}

}  // namespace

Spread::Spread(std::uint64_t key) {
  for (double& start : at_) {
    start = static_cast<double>(base::split_mix(key) >> 11) * 0x1p-53;
    key += base::kSplitMixStep;
  }
}

void Spread::next() {
  constexpr double kStep[] = {0.7548776662466927, 0.5698402909980532};
  for (int i = 0; i < 2; ++i) {
    at_[i] += kStep[i];
    if (at_[i] >= 1) at_[i] -= 1;
  }
}

void Visibility::add(const Vec& from, const Vec& normal, const Vec& to, const Vec& to_normal) {
  const Vec origin = off_surface(from, normal), way = off_surface(to, to_normal) - origin;
  const double distance = length(way);
  push(origin, vec64::unit(way), distance);
}

void Visibility::add(const Vec& from, const Vec& normal, const Vec& direction, double distance) {
  push(off_surface(from, normal), direction, distance);
}

void Visibility::push(const Vec& origin, const Vec& direction, double distance) {
  float* const to[] = {origin_.x, origin_.y, origin_.z, direction_.x, direction_.y, direction_.z};
  for (std::size_t i = 0; i < 3; ++i) {
    to[i][size_] = static_cast<float>(origin[i]);
    to[3 + i][size_] = static_cast<float>(direction[i]);
  }
  distance_[size_++] = static_cast<float>(distance);
}

void Visibility::trace() {
  const StageTimer timer(context_.stats.times, Stage::kShadow);
  context_.rays.occluded(arrays_of(origin_, direction_, time_), size_, distance_);
  context_.stats.shadow_rays += static_cast<std::uint64_t>(size_);
}

}  // namespace tessera::render::TESSERA_ISA::radiosity

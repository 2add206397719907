#include "light_field/nearest_cameras.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera::light_field {
namespace {

/// The share of a doubled distance in the penalty, radians.
constexpr float kResolutionShare = 0.05f;
/// Gaps of the set are bridged up to so many times the usual angle between neighbours.
constexpr float kBridge = 3;

}  // namespace

NearestCameras::NearestCameras(const LightField& field) {
  for (const View& view : field.manifest().views) places_.emplace_back(view.camera.place() - field.origin());
  // The angle between neighbours as seen from the target, the origin, in the mean.
  std::vector<Imath::V3f> directions;
  for (const Imath::V3f& place : places_) directions.push_back(place.normalized());
  double sum = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    float nearest = 2;
    for (std::size_t j = 0; j < directions.size(); ++j) {
      if (i != j) nearest = std::min(nearest, (directions[i] - directions[j]).length());
    }
    sum += nearest;
  }
  limit_ = kBridge * static_cast<float>(sum / static_cast<double>(places_.size()));
}

float NearestCameras::penalty(std::uint32_t view, const LocalRay& ray, const Imath::V3f& p) const {
  const Imath::V3f to_camera = places_[view] - p, to_eye = ray.origin - p;
  const float camera = to_camera.length(), eye = to_eye.length();
  const float product = std::max(camera * eye, std::numeric_limits<float>::min());
  const float sine = to_camera.cross(to_eye).length() / product;
  const float angle = to_camera.dot(to_eye) > 0 ? sine : 2 - sine;
  return angle + kResolutionShare * std::max(0.0f, camera - eye) * camera / product;
}

void NearestCameras::candidates(const LocalRay& ray, const Imath::V3f& p,
                                std::vector<std::uint32_t>& views) const {
  std::vector<std::pair<float, std::uint32_t>> all(places_.size());
  for (std::uint32_t v = 0; v < places_.size(); ++v) all[v] = {penalty(v, ray, p), v};
  const std::size_t count = std::min(kCandidates, all.size());
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  views.clear();
  for (std::size_t i = 0; i < count; ++i) views.push_back(all[i].second);
  std::ranges::sort(views);
}

}  // namespace tessera::light_field

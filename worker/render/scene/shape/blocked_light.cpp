#include "render/scene/shape/blocked_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "render/core/vec64.h"
#include "render/light/light_source.h"

namespace tessera::render {
namespace {

using vec64::Vec;

constexpr std::size_t kWalks = 1024;
constexpr int kWalkEvents = 4;
constexpr int kRayPassings = 4;
constexpr double kScattered = 0.5;  // share of the light that a surface gets
constexpr double kApart = 1e-4;     // rays stay apart from a surface by this part of the distance to it
constexpr double kNowhere = std::numeric_limits<double>::infinity();

bool is_opaque(const MaterialTable& table, std::int32_t index) {
  if (index < 0) return true;
  const MaterialRecord& material = table.materials[static_cast<std::size_t>(index)];
  if (material.flags & (kHasOpacity | kPassesStraight | kTransmits | kHasInside)) return false;
  return !(material.flags & kMixed) || (is_opaque(table, material.mix_a) && is_opaque(table, material.mix_b));
}

/// The random numbers of walks, which are the same for every scene.
class Numbers {
 public:
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Vec direction() {
    const double z = 1 - 2 * (*this)(), r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * std::numbers::pi * (*this)();
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::mt19937_64 engine_{1};
};

struct Ray {
  Vec origin, direction;
};

/// Answers how far rays go until something opaque is in their way.
class Reach {
 public:
  Reach(const SceneArrays& arrays, const RayQuery& rays) : arrays_(arrays), rays_(rays) {
    for (const MaterialRecord& material : arrays.materials.materials)
      opaque_by_material_.push_back(is_opaque(
          arrays.materials, static_cast<std::int32_t>(&material - arrays.materials.materials.data())));
  }

  /// Distances; infinite where nothing is. At most kWalks rays.
  std::vector<double> operator()(const std::vector<Ray>& rays) {
    std::vector<double> reached(rays.size(), 0);
    std::vector<std::size_t> open(rays.size());
    for (std::size_t i = 0; i < open.size(); ++i) open[i] = i;
    for (int passing = 0; passing <= kRayPassings && !open.empty(); ++passing) {
      for (std::size_t k = 0; k < open.size(); ++k) set(k, rays[open[k]], reached[open[k]]);
      rays_.nearest({ox_, oy_, oz_, dx_, dy_, dz_}, static_cast<int>(open.size()), false,
                    {t_, u_, v_, primitive_, shape_, instance_});
      std::size_t left = 0;
      for (std::size_t k = 0; k < open.size(); ++k) {
        const std::size_t i = open[k];
        if (shape_[k] < 0) {
          reached[i] = kNowhere;
        } else {
          reached[i] += double{t_[k]};
          if (passing == kRayPassings || stops(shape_[k])) continue;
          reached[i] *= 1 + kApart;
          open[left++] = i;
        }
      }
      open.resize(left);
    }
    return reached;
  }

 private:
  void set(std::size_t k, const Ray& ray, double from) {
    const Vec origin = ray.origin + ray.direction * from;
    ox_[k] = static_cast<float>(origin[0]), oy_[k] = static_cast<float>(origin[1]);
    oz_[k] = static_cast<float>(origin[2]), dx_[k] = static_cast<float>(ray.direction[0]);
    dy_[k] = static_cast<float>(ray.direction[1]), dz_[k] = static_cast<float>(ray.direction[2]);
  }
  bool stops(std::int32_t shape) const {
    const ShapeRecord& record = arrays_.shapes.shapes[static_cast<std::size_t>(shape)];
    return (record.flags & kHasAlpha) == 0 &&
           (record.material < 0 || opaque_by_material_[static_cast<std::size_t>(record.material)]);
  }

  const SceneArrays& arrays_;
  const RayQuery& rays_;
  std::vector<bool> opaque_by_material_;
  alignas(64) float ox_[kWalks] = {}, oy_[kWalks] = {}, oz_[kWalks] = {};
  alignas(64) float dx_[kWalks] = {}, dy_[kWalks] = {}, dz_[kWalks] = {};
  alignas(64) float t_[kWalks] = {}, u_[kWalks] = {}, v_[kWalks] = {};
  alignas(64) std::int32_t primitive_[kWalks] = {}, shape_[kWalks] = {}, instance_[kWalks] = {};
};

/// Light from one direction, and how far away it comes from.
struct LightSample {
  Vec direction = {};
  double distance = kNowhere;
  double light = 0;  // mean irradiance of a surface of any orientation, over the probability of the sample
};

/// Samples lights, half of the samples by power and half evenly.
class LightSamples {
 public:
  explicit LightSamples(const LightTable& table) : table_(table) {
    for (std::size_t i = 0; i < table.lights.size(); ++i) {
      const LightRecord& light = table.lights[i];
      const double power = light.same_as >= 0 ? 0 : table.sources(light.kind).power(table, light);
      if (!(power > 0 && std::isfinite(power))) continue;
      lights_.push_back(i);
      ends_.push_back(total_ += power);
    }
  }

  bool none() const { return lights_.empty(); }

  LightSample at(const Vec& place, Numbers& random) const {
    const bool by_power = random() < 0.5;
    const double u = random();
    const auto count = static_cast<double>(lights_.size());
    const auto found = by_power ? std::ranges::upper_bound(ends_, u * total_) - ends_.begin()
                                : static_cast<std::ptrdiff_t>(u * count);
    const auto k = std::min(static_cast<std::size_t>(found), lights_.size() - 1);
    const double power = ends_[k] - (k > 0 ? ends_[k - 1] : 0);
    const double probability = 0.5 * power / total_ + 0.5 / count;
    const LightRecord& light = table_.lights[lights_[k]];
    const LightSource& source = table_.sources(light.kind);
    LightSample sample = source.traits.at_infinity ? from_afar(light, source.traits, power, random)
                                                   : from_near(light, source, place);
    sample.light /= 4 * probability;
    return sample;
  }

 private:
  /// The power of lights at infinity is what falls on the scene's disk.
  LightSample from_afar(const LightRecord& light, const LightTraits& traits, double power,
                        Numbers& random) const {
    const Vec direction = traits.delta ? vec64::vec(light.direction) * -1.0 : random.direction();
    return {direction, kNowhere, power / scene_disk(table_)};
  }
  /// Lights are as small as their bounds' middle, and closer to none than the bounds are wide.
  LightSample from_near(const LightRecord& light, const LightSource& source, const Vec& place) const {
    const LightBounds bounds = source.bounds(table_, light);
    const double extent = vec64::length(bounds.high - bounds.low) / 2;
    const Vec way = (bounds.low + bounds.high) * 0.5 - place;
    const double distance = vec64::length(way);
    if (!std::isfinite(distance) || !(distance > 0)) return {};
    const Vec direction = vec64::unit(way);
    const double cosine = -vec64::dot(bounds.axis, direction);
    const double off = std::acos(std::clamp(bounds.two_sided ? std::abs(cosine) : cosine, -1.0, 1.0));
    if (off > bounds.angle + bounds.reach) return {};
    const double apart = std::max(distance, extent);
    return {direction, distance * (1 - kApart) - extent, bounds.intensity / (apart * apart)};
  }

  const LightTable& table_;
  std::vector<std::size_t> lights_;
  std::vector<double> ends_;  // running sums of their powers
  double total_ = 0;
};

}  // namespace

BlockedLight measure_blocked_light(const SceneArrays& arrays, const RayQuery& rays) {
  BlockedLight measured;
  const LightSamples lights(arrays.lights);
  if (lights.none()) return measured;
  Numbers random;
  Reach reach(arrays, rays);
  std::vector<Ray> walks(kWalks);
  for (Ray& walk : walks) walk.direction = random.direction();
  double share = 1;
  for (int event = 0; event < kWalkEvents && !walks.empty(); ++event, share *= kScattered) {
    const std::vector<double> met = reach(walks);
    std::size_t left = 0;
    for (std::size_t i = 0; i < walks.size(); ++i) {
      // Half-way to the surface, which roundings leave on the side that the walk comes from.
      if (std::isfinite(met[i])) walks[left++].origin = walks[i].origin + walks[i].direction * (met[i] / 2);
    }
    walks.resize(left);
    std::vector<Ray> to_lights;
    std::vector<LightSample> samples;
    for (const Ray& walk : walks) {
      samples.push_back(lights.at(walk.origin, random));
      to_lights.push_back({walk.origin, samples.back().direction});
    }
    const std::vector<double> free = reach(to_lights);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double light = share * samples[i].light;
      if (free[i] >= samples[i].distance) {
        measured.arriving += light, measured.arriving_squares += light * light;
      } else {
        measured.blocked += light, measured.blocked_squares += light * light;
      }
    }
    for (Ray& walk : walks) walk.direction = random.direction();
  }
  return measured;
}

}  // namespace tessera::render

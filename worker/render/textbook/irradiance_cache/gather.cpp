#include "render/textbook/irradiance_cache/gather.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/integrator/stage_timer.h"
#include "render/transport/vertex/dimensions.h"
#include "wire/limits.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec3 broadcast(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

/// A density so low that the light which the first segment meets counts nothing against that which light
/// sampling has found at the record's points: its weight is zero.
constexpr float kLeftToLightSampling = 1e-30f;

/// Least distance of what rays meet: a record's gradients go with the inverse.
constexpr float kLeastDistance = 1e-18f;

/// Bound on a record's radius by the nearest hit, which shadows points beside it, however little of the
/// hemisphere it takes: the mean distance would not know of it [Tabellion & Lamorlette 2004 go by the nearest
/// alone].
constexpr double kNearest = 2;  // times its distance

/// How much of a record's gradients is kept, given how much light it has and how steeply that changes along
/// the surface, and its radius bounded: the record reaches no further than its gradient leaves light [Ward
/// Larson & Shakespeare 1998, chapter 12], and as far as the settings want; where that is further, its
/// gradient is flattened.
float bound_radius(const IrradianceCacheSettings& settings, float light, float steepest, RecordSite& site) {
  if (steepest * site.radius > light) site.radius = light / steepest;
  const float most = settings.most_reach * site.pixel / settings.error,
              least = settings.least_reach * site.pixel / settings.error;
  site.radius = std::min(site.radius, most);
  if (site.radius >= least) return 1;
  const float kept = site.radius / least;
  site.radius = least;
  return kept;
}

RecordSite site_of(const RecordPlace& place, double mean_distance, double nearest) {
  RecordSite site{};
  std::copy_n(place.p, 3, site.p);
  std::copy_n(place.n, 3, site.n);
  site.radius = static_cast<float>(std::min(mean_distance, kNearest * nearest));
  site.pixel = place.pixel;
  return site;
}

// A record that is met on the way holds the light of one event more than the rest of the path could have.
// Where paths are that long, this is less than 0.5 % of the light for surfaces that reflect 70 %.
constexpr std::int32_t kLongPaths = 12;

/// Rays of records by how far these reach. A record's noise is that of all pixels which it reaches, and their
/// number grows with the square of that reach: the error of all pixels for so many rays in all is least where
/// rays are in proportion to the reach (Lagrange: the sum of reach^2 / rays, with the sum of rays given).
/// Those that reach as far as the settings let them have all the rays of the settings; each level has half of
/// the next.
std::vector<int> rays_by_level(const IrradianceCacheSettings& settings) {
  const double least = std::max(settings.samples * double{settings.least_reach / settings.most_reach},
                                double{wire::kLeastCacheSamples});
  std::vector<int> rays;
  for (double n = settings.samples; rays.empty() || n >= least; n /= 2) rays.push_back(static_cast<int>(n));
  std::reverse(rays.begin(), rays.end());
  return rays;
}

}  // namespace

Gather::Gather(const IntegratorContext& context, const IrradianceCache* given)
    : IrradianceCached(context, context.scene.max_depth >= kLongPaths ? given : nullptr, false) {
  const IrradianceCacheSettings& settings = context.scene.irradiance_cache;
  for (const int rays : rays_by_level(settings)) {
    hemispheres_.emplace_back(rays);
    if (settings.glossy_bands > 0) glossy_hemispheres_.emplace_back(rays, settings.glossy_bands);
  }
}

std::size_t Gather::level_of(const RecordSite& site) const {
  const IrradianceCacheSettings& settings = scene_.irradiance_cache;
  // Share of the most reach; each level is for twice the reach of the one before.
  const float part = site.radius * settings.error / (settings.most_reach * site.pixel);
  std::size_t level = hemispheres_.size() - 1;
  for (float of_level = 0.5f; level > 0 && part <= of_level; of_level /= 2) --level;
  return level;
}

template <class H>
typename H::Estimate Gather::look_around(const RecordPlace& place, std::vector<H>& hemispheres,
                                         RecordSite& site) {
  typename H::Estimate estimate;
  for (std::size_t level = 0;;) {
    trace_cells(place, hemispheres[level]);
    const StageTimer timer(stats_.times, Stage::kShading);
    estimate = hemispheres[level].estimate();
    site = site_of(place, estimate.mean_distance, estimate.nearest);
    const std::size_t wanted = level_of(site);
    if (level > 0 || wanted == 0) return estimate;
    level = wanted;
  }
}

IrradianceRecord Gather::make_record(const RecordPlace& place) {
  IrradianceRecord record{};
  const Hemisphere::Estimate estimate = look_around(place, hemispheres_, record);
  const Frame frame = Frame::from_normal(broadcast(place.n));
  const Float axes[3][2] = {{frame.x.x, frame.y.x}, {frame.x.y, frame.y.y}, {frame.x.z, frame.y.z}};
  for (int axis = 0; axis < 3; ++axis) {
    const double x = double{axes[axis][0].lane(0)}, y = double{axes[axis][1].lane(0)};
    const auto in_render_space = [x, y](const double(&v)[2]) {
      return static_cast<float>(v[0] * x + v[1] * y);
    };
    for (int band = 0; band < kBands; ++band) {
      record.rotation[band][axis] = in_render_space(estimate.rotation[band]);
      record.translation[band][axis] = in_render_space(estimate.translation[band]);
    }
  }
  float steepest = 0, irradiance = 0;
  for (int band = 0; band < kBands; ++band) {
    record.irradiance[band] = static_cast<float>(estimate.irradiance[band]);
    const float* const g = record.translation[band];
    steepest = std::max(steepest, std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]));
    irradiance = std::max(irradiance, record.irradiance[band]);
  }
  const float kept = bound_radius(scene_.irradiance_cache, irradiance, steepest, record);
  if (kept == 1) return record;
  for (auto& gradient : record.translation) {
    for (float& component : gradient) component *= kept;
  }
  return record;
}

void Gather::make_record(const RecordPlace& place, GlossyRecords& records) {
  RecordSite site;
  RadianceHemisphere::Estimate estimate = look_around(place, glossy_hemispheres_, site);
  // All directions together, by the norms of the coefficients.
  double light[kBands] = {}, change[kBands] = {};
  std::vector<float>& numbers = estimate.numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    double& sum = (i % GlossyRecords::kOfCoefficient < kBands ? light : change)[i % kBands];
    sum += double{numbers[i]} * double{numbers[i]};
  }
  const float kept = bound_radius(
      scene_.irradiance_cache, static_cast<float>(std::sqrt(*std::max_element(light, light + kBands))),
      static_cast<float>(std::sqrt(*std::max_element(change, change + kBands))), site);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i % GlossyRecords::kOfCoefficient >= kBands) numbers[i] *= kept;
  }
  records.sites.push_back(site);
  records.numbers.insert(records.numbers.end(), numbers.begin(), numbers.end());
}

void Gather::trace_cells(const RecordPlace& place, auto& hemisphere) {
  for (int first = 0; first < hemisphere.cells(); first += kBatch) {
    const int n = std::min(hemisphere.cells() - first, kBatch);
    start_paths(place, hemisphere, first, n);
    trace(1, n);
    for (int i = 0; i < n; i += kWidth) {
      const Vec3 local{Float::load(cell_direction_[0] + i), Float::load(cell_direction_[1] + i),
                       Float::load(cell_direction_[2] + i)};
      keep(hemisphere, first + i, std::min(n - i, kWidth), local, vec3_of(batch_.summable_radiance(i)),
           max(Float::load(sample_distance_ + i), kLeastDistance));
    }
  }
}

void Gather::keep(Hemisphere& hemisphere, int first, int n, Vec3, Vec3 light, Float distance) {
  alignas(64) float radiance[kBands][kWidth], distances[kWidth];
  light.x.store(radiance[0]), light.y.store(radiance[1]), light.z.store(radiance[2]);
  distance.store(distances);
  for (int lane = 0; lane < n; ++lane)
    hemisphere.set(first + lane, {radiance[0][lane], radiance[1][lane], radiance[2][lane]}, distances[lane]);
}

void Gather::keep(RadianceHemisphere& hemisphere, int first, int, Vec3 directions, Vec3 light,
                  Float distance) {
  hemisphere.set(first, directions, light, distance);
}

void Gather::start_paths(const RecordPlace& place, const auto& hemisphere, int first, int n) {
  batch_.start(place.random_key, static_cast<std::uint32_t>(first), n);
  const Frame frame = Frame::from_normal(broadcast(place.n));
  Surface surface;
  surface.p = broadcast(place.p), surface.ng = broadcast(place.ng), surface.error = Float(place.error);
  for (int i = 0; i < n; i += kWidth) {
    const Sampler sampler = batch_.sampler(Int::iota(i), Mask::all());
    const Vec2 u = sampler.get_2d(dimension::kFirstEvent + dimension::kBsdfDirection);
    const Vec3 local = hemisphere.direction(Int::iota(first + i), u);
    local.x.store(cell_direction_[0] + i), local.y.store(cell_direction_[1] + i),
        local.z.store(cell_direction_[2] + i);
    const Vec3 direction = frame.to_world(local);
    WidePath path;
    path.origin = path.reference = offset_origin(surface, direction);
    path.direction = direction;
    path.beta = Spectrum(1.0f);
    path.pdf = Float(kLeftToLightSampling);
    path.roulette_scale = Float(1.0f);
    path.slot = Int::iota(i);
    path.normal = frame.z;
    path.time = Float(0.0f);
    path.medium = Int(-1);
    store(scene_, path, paths_, i);
    Float(std::numeric_limits<float>::infinity()).store(sample_distance_ + i);
  }
}

void Gather::met(Encounter& e) {
  if (e.depth == 1) scatter(e.hit.t, sample_distance_, e.path.slot, e.on_surface);
  IrradianceCached::met(e);
}

}  // namespace tessera::render::TESSERA_ISA

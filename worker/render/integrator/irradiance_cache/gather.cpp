#include "render/integrator/irradiance_cache/gather.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec3 broadcast(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

/// A density so low that the light which the first segment meets counts nothing against that which light
/// sampling has found at the record's points: its weight is zero.
constexpr float kLeftToLightSampling = 1e-30f;

/// What is near shadows points beside it, however little of the hemisphere it takes: the mean distance would
/// not know of it [Tabellion & Lamorlette 2004 go by the nearest alone].
constexpr double kNearest = 2;  // times its distance

/// The record reaches no further than its gradient leaves light [Ward Larson & Shakespeare 1998, chapter 12],
/// and as far as the settings want; where that is further, its gradient is flattened.
void bound_radius(const IrradianceCacheSettings& settings, IrradianceRecord& record) {
  float steepest = 0, irradiance = 0;
  for (int band = 0; band < kBands; ++band) {
    const float* const g = record.translation[band];
    steepest = std::max(steepest, std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]));
    irradiance = std::max(irradiance, record.irradiance[band]);
  }
  if (steepest * record.radius > irradiance) record.radius = irradiance / steepest;
  const float most = settings.most_reach * record.pixel / settings.error,
              least = settings.least_reach * record.pixel / settings.error;
  record.radius = std::min(record.radius, most);
  if (record.radius >= least) return;
  for (auto& gradient : record.translation) {
    for (float& component : gradient) component *= record.radius / least;
  }
  record.radius = least;
}

// A record that is met on the way holds the light of one event more than the rest of the path could have.
// Where paths are that long, this is less than 0.5 % of the light for surfaces that reflect 70 %.
constexpr std::int32_t kLongPaths = 12;

}  // namespace

Gather::Gather(const IntegratorContext& context, const IrradianceCache* given)
    : IrradianceCached(context, context.scene.max_depth >= kLongPaths ? given : nullptr, false),
      hemisphere_(context.scene.irradiance_cache.samples) {}

IrradianceRecord Gather::make_record(const RecordPlace& place) {
  for (int first = 0; first < hemisphere_.cells(); first += kBatch)
    trace_cells(place, first, std::min(hemisphere_.cells() - first, kBatch));
  const StageTimer timer(stats_.times, Stage::kShading);
  const Hemisphere::Estimate estimate = hemisphere_.estimate();
  const Frame frame = Frame::from_normal(broadcast(place.n));
  const Float axes[3][2] = {{frame.x.x, frame.y.x}, {frame.x.y, frame.y.y}, {frame.x.z, frame.y.z}};
  IrradianceRecord record{};
  for (int axis = 0; axis < 3; ++axis) {
    record.p[axis] = place.p[axis];
    record.n[axis] = place.n[axis];
    const double x = double{axes[axis][0].lane(0)}, y = double{axes[axis][1].lane(0)};
    const auto in_render_space = [x, y](const double(&v)[2]) {
      return static_cast<float>(v[0] * x + v[1] * y);
    };
    for (int band = 0; band < kBands; ++band) {
      record.rotation[band][axis] = in_render_space(estimate.rotation[band]);
      record.translation[band][axis] = in_render_space(estimate.translation[band]);
    }
  }
  for (int band = 0; band < kBands; ++band)
    record.irradiance[band] = static_cast<float>(estimate.irradiance[band]);
  record.radius = static_cast<float>(std::min(estimate.mean_distance, kNearest * estimate.nearest));
  record.pixel = place.pixel;
  bound_radius(scene_.irradiance_cache, record);
  return record;
}

void Gather::trace_cells(const RecordPlace& place, int first, int n) {
  batch_.start(place.key, static_cast<std::uint32_t>(first), n);
  const Frame frame = Frame::from_normal(broadcast(place.n));
  Surface surface;
  surface.p = broadcast(place.p), surface.ng = broadcast(place.ng), surface.error = Float(place.error);
  for (int i = 0; i < n; i += kWidth) {
    const Sampler sampler = batch_.sampler(Int::iota(i), Mask::all());
    const Vec2 u = sampler.get_2d(dimension::kFirstEvent + dimension::kBsdfDirection);
    const Vec3 direction = frame.to_world(hemisphere_.direction(Int::iota(first + i), u));
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
    Float(std::numeric_limits<float>::infinity()).store(distance_ + i);
  }
  trace(1, n);
  for (int i = 0; i < n; i += kWidth) {
    const Vec3 rgb = rgb_of(batch_.radiance(i));
    alignas(64) float radiance[kBands][kWidth];
    rgb.x.store(radiance[0]), rgb.y.store(radiance[1]), rgb.z.store(radiance[2]);
    for (int lane = 0; lane < std::min(n - i, kWidth); ++lane)
      hemisphere_.set(first + i + lane, {radiance[0][lane], radiance[1][lane], radiance[2][lane]},
                      distance_[i + lane]);
  }
}

Mask Gather::settle(WidePath& path, const Vertex& v, Float t, Mask hit, int depth) {
  if (depth == 1) scatter(t, distance_, path.slot, hit);
  return IrradianceCached::settle(path, v, t, hit, depth);
}

}  // namespace tessera::render::TESSERA_ISA

#include "render/textbook/preview/preview.h"

#include "render/core/constants.h"
#include "render/integrator/algorithm_list.h"
#include "render/integrator/stage_timer.h"
#include "render/sampling/hash.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

namespace {

static_assert(kPlaceSteps == kSubPixels);

/// Bins that are kept, at most: 24 KB each.
constexpr std::size_t kMostBins = 1024;

/// The distance along a ray that meets the surface. The point on it is most precise across the surface, not
/// along it.
Float distance_to(const Surface& surface, Vec3 origin, Vec3 direction) {
  constexpr float kGrazing = 0.01f;
  const Vec3 way = surface.p - origin;
  const Float cosine = dot(direction, surface.ng);
  const Mask steep = abs(cosine) > kGrazing;
  return select(steep, dot(way, surface.ng) / select(steep, cosine, 1.0f), dot(way, direction));
}

}  // namespace

Preview::Preview(const IntegratorContext& context)
    : scene_(context.scene),
      frame_(static_cast<const PreviewFrame&>(*context.prepared)),
      rays_(context.rays),
      stats_(context.stats),
      batch_(context),
      raster_(std::make_unique<Raster>(context.scene, frame_.clusters(), context.rays)) {}

std::unique_ptr<const Prepared> Preview::prepare(const SceneTables& scene,
                                                 std::span<const std::string_view>) {
  return std::make_unique<PreviewFrame>(scene);
}

bool Preview::render(SampleSource& work, Film& film, std::stop_token stop) {
  {
    const StageTimer timer(stats_.times, Stage::kShadow);
    if (!frame_.finish(rays_, stop)) return false;
  }
  while (batch_.start(work, paths_, kBatch, SamplePlaces::kSameInAllPixels)) {
    if (stop.stop_requested()) return false;
    for (int first = 0; first < batch_.size(); first += kWidth) shade(first);
    batch_.finish(film, true);
  }
  return true;
}

const BinHits& Preview::hits_of(BinName name) {
  if (latest_ != nullptr && name == latest_name_) return *latest_;
  latest_name_ = name;
  if (const auto known = bins_.find(name); known != bins_.end()) return *(latest_ = known->second.get());
  const StageTimer timer(stats_.times, Stage::kIntersection);
  if (bins_.size() == kMostBins) bins_.clear();
  const PixelPlace place = common_place(scene_.filter, UInt(name.second));
  const View view = frame_.view(place.x.lane(0), place.y.lane(0));
  const auto columns = static_cast<std::uint32_t>(view.bins.columns());
  raster_->render(view, static_cast<int>(name.first % columns), static_cast<int>(name.first / columns));
  auto& hits = *(bins_[name] = std::make_unique<BinHits>());
  raster_->resolve(hits);
  return *(latest_ = &hits);
}

/// Finds what is seen through 16 samples.
Hit Preview::find(int first) {
  alignas(64) std::int32_t shape[kWidth], primitive[kWidth], instance[kWidth];
  alignas(64) float t[kWidth] = {}, u[kWidth] = {}, v[kWidth] = {};
  const auto columns = static_cast<std::uint32_t>(frame_.view(0, 0).bins.columns());
  for (int i = 0; i < kWidth; ++i) {
    shape[i] = instance[i] = -1;
    primitive[i] = 0;
    if (first + i >= batch_.size()) continue;
    const SampleName& name = batch_.name(first + i);
    const BinHits& hits = hits_of({name.y / kBinSide * columns + name.x / kBinSide, name.index});
    const std::size_t pixel = name.y % kBinSide * kBinSide + name.x % kBinSide;
    shape[i] = hits.shape[pixel];
    primitive[i] = hits.primitive[pixel];
    instance[i] = hits.instance[pixel];
    t[i] = hits.t[pixel];
    u[i] = hits.u[pixel];
    v[i] = hits.v[pixel];
  }
  return {Float::load(t),       Float::load(u),   Float::load(v),
          Int::load(primitive), Int::load(shape), Int::load(instance)};
}

void Preview::shade(int first) {
  const Mask active = Mask::first(batch_.size() - first);
  Hit found = find(first);
  const StageTimer timer(stats_.times, Stage::kShading);
  const WidePath path = load(scene_, paths_, first);
  Mask hit = active & (found.shape >= 0);
  Vertex v;
  v.wo = -path.direction;
  v.time = Float(0.0f);
  v.surface = surface_at(scene_.shapes, found, path.origin, path.direction, hit, scene_.any_tangents);
  found.t = distance_to(v.surface, path.origin, path.direction);
  hit &= is_within_reach(scene_.sensor, path.direction, found.t, Float(0.0f));
  add_background(path, and_not(active, hit));
  if (none(hit)) return;

  if (const Mask lit = hit & (v.surface.light >= 0); any(lit)) {
    const Spectrum radiance = emitted_radiance(scene_.lights, v.surface.light, v.surface, v.wo, lit);
    batch_.add_radiance(radiance, path.slot, lit);
  }
  interact(scene_, v.surface, v.wo, Float(0.5f), Spectra(), hit, v.at);
  batch_.record_first_hit(v, found, path.slot, hit);
  batch_.add_radiance(reflected(v, path.slot, hit), path.slot, hit);
}

void Preview::add_background(const WidePath& path, Mask missed) {
  if (none(missed)) return;
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Spectrum radiance = environment_radiance(scene_.lights, light, path.origin, path.direction, missed);
    batch_.add_radiance(radiance, path.slot, missed);
  }
}

/// Ambient light on the surface's colour, and each lamp's light by the material's own lobes. Mirrors and
/// clear glass, whose lobes no lamp is seen in, are painted in their colour.
Spectrum Preview::reflected(const Vertex& v, Int slot, Mask hit) const {
  const Spectrum paint = albedo_of(v.at, hit) * Float(kInvPi);
  const Vec3 n = face_forward(v.at.frame.z, v.wo);
  const Mask painted = hit & ((v.at.flags & kAllDelta) != 0);
  const ShadowReceiver receiver{v.surface.p, v.surface.ng,
                                to_unit_float(hash(batch_.key(slot, hit))) * (2 * kPi)};
  Spectrum sum = paint * frame_.lighting().ambient_irradiance(n);
  for (std::size_t i = 0; i < frame_.lighting().lamps.size(); ++i) {
    const LampLight light = light_of(scene_, frame_.lighting().lamps[i], v.surface.p, hit);
    if (none(light.lit)) continue;
    Spectrum f_cos = eval_bsdf(v.at, v.wo, light.wi, and_not(light.lit, painted)).f_cos;
    f_cos = select(painted, paint * max(dot(n, light.wi), 0.0f), f_cos);
    Spectrum more = f_cos * light.irradiance;
    // A lamp at its centre would be too bright in a narrow lobe.
    more *= min(light.most / max(more.max_component(), 1e-30f), 1.0f);
    const Mask adds = and_not(light.lit, is_black(more));
    if (none(adds)) continue;
    if (i < frame_.shadows().size())
      more *= frame_.shadows()[i]->visible(receiver, scene_.preview.shadows, adds);
    sum += select_or_zero(adds, more);
  }
  return sum;
}

const ListedAlgorithm preview{{.name = "preview", .make = &make<Preview>, .prepare = &Preview::prepare}};

}  // namespace tessera::render::TESSERA_ISA

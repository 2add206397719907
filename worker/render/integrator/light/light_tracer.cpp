#include "render/integrator/light/light_tracer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/accel/trace.h"
#include "render/camera/camera.h"
#include "render/film/filter_value.h"
#include "render/film/summable.h"
#include "render/integrator/interaction.h"
#include "render/integrator/passing.h"
#include "render/integrator/path/wavefront.h"
#include "render/light/emission.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Dimensions of light paths have pairs of their own, apart from those of the camera rays of the same pixel.
constexpr int kLightPath = 3 << 20;
constexpr int kChooseLight = kLightPath, kPlace = kLightPath + 1, kDirection = kLightPath + 2,
              kFirstEvent = kLightPath + 3;
enum Event { kLens, kScatter, kLobe, kRoulette, kPairsPerEvent };

/// Paths end at random only once they carry less than the inverse of this part of what they began with.
constexpr float kRouletteCaution = 2;

/// Collects one sample of every pixel of a tile.
class PlaneSink final : public FilmSink {
 public:
  PlaneSink(std::vector<float>& planes, std::size_t stride) : planes_(planes), stride_(stride) {}
  void begin_pixels(std::span<const std::uint32_t> pixels) override { pixels_ = pixels; }
  void add_sample(const float* planes, std::size_t stride) override {
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t i = 0; i < pixels_.size(); ++i) planes_[c * stride_ + pixels_[i]] += planes[c * stride + i];
    }
  }
  void end_pixels() override {}

 private:
  std::vector<float>& planes_;
  std::size_t stride_;
  std::span<const std::uint32_t> pixels_;
};

/// Cosines with shading and geometric normal do not cancel as they do on a path from the eye [Veach 1997, section 5.3].
Float normal_ratio(const Surface& s, const Frame& frame, Vec3 from, Vec3 to) {
  const Float in = abs(dot(from, frame.z)) / max(abs(dot(from, s.ng)), 1e-6f);
  return in * abs(dot(to, s.ng)) / max(abs(dot(to, frame.z)), 1e-6f);
}

}  // namespace

struct LightTracer::Vertex {
  Float time;     // of the path
  Vec3 to_light;  // back along the path
  Spectrum beta;  // flux
  Int slot;
  Sampler sampler;
  int first_pair;
  Surface surface;
  Interaction at;
};

LightTracer::LightTracer(const SceneTables& scene, const TileRequest& tile, FilmSink& film, RenderStats& stats)
    : scene_(scene), tile_(tile), film_(film), stats_(stats), pixels_((tile.x1 - tile.x0) * (tile.y1 - tile.y0)) {
  std::iota(pixels_.begin(), pixels_.end(), 0u);
  stride_ = (pixels_.size() + kWidth) / kWidth * kWidth;
}

bool LightTracer::render(std::stop_token stop) {
  film_.begin_pixels(pixels_);
  const std::int32_t paths = scene_.camera.width * scene_.camera.height;
  const bool lit = !scene_.lights.selection.threshold.empty() && scene_.max_depth > 0;
  for (std::uint32_t pass = tile_.sample_begin; pass < tile_.sample_end; ++pass) {
    planes_.assign(4 * stride_, 0.0f);
    if (!add_visible_lights(pass, stop)) return false;
    for (std::int32_t first = 0; first < paths && lit; first += kBatch) {
      if (stop.stop_requested()) return false;
      start_paths(first, std::min<std::int32_t>(kBatch, paths - first), pass);
      for (int depth = 0; alive_ > 0; ++depth) advance(depth);
    }
    const StageTimer timer(stats_.times, Stage::kFilm);
    film_.add_sample(planes_.data(), stride_);
  }
  film_.end_pixels();
  return true;
}

bool LightTracer::add_visible_lights(std::uint32_t pass, std::stop_token stop) {
  PlaneSink sink(planes_, stride_);
  const TileRequest sample{tile_.x0, tile_.y0, tile_.x1, tile_.y1, pass, pass + 1, tile_.seed_offset};
  const auto eye = std::make_unique<Wavefront>(scene_, stats_, nullptr, 0);
  return eye->render(sample, sink, stop);
}

void LightTracer::start_paths(std::int32_t first, std::int32_t count, std::uint32_t pass) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  alive_ = 0;
  const UInt reversed = reverse_bits(UInt(pass));
  for (std::int32_t slot = 0; slot < count; slot += kWidth) {
    const Mask active = Mask::first(count - slot);
    // A path belongs to a pixel, if only by its random numbers.
    const Int index = Int::iota(first + slot);
    const UInt hash =
        Sampler::pixel_hash(scene_.sampler.seed + tile_.seed_offset, bit_cast<std::uint32_t>(index), UInt(0x4c696768u));
    hash.store(pixel_hash_ + slot);
    reversed.store(reversed_sample_ + slot);
    const Sampler sampler(scene_.sampler.kind, hash, reversed);

    const DiscreteSample choice = sample_discrete(scene_.lights.selection, sampler.get_2d(kChooseLight).x, active);
    const Emission ray =
        sample_emission(scene_.lights, choice.index, sampler.get_2d(kPlace), sampler.get_2d(kDirection), active);
    const Mask alive = active & ray.valid & (choice.pmf > 0.0f);
    const Float scale = 1.0f / (select(alive, choice.pmf, 1.0f) * static_cast<float>(scene_.camera.width) *
                                static_cast<float>(scene_.camera.height));
    paths_.origin.append(ray.origin + ray.offset, alive, alive_);
    paths_.direction.append(ray.direction, alive, alive_);
    paths_.beta.append(ray.flux * scale, alive, alive_);
    if (scene_.any_motion) compress_store(sampler.get_2d(dimension::kTime).x, alive, paths_.time + alive_);
    compress_store(1.0f / max((ray.flux * scale).max_component(), 1e-30f), alive, inverse_start_ + alive_);
    alive_ += compress_store(Int::iota(slot), alive, paths_.slot + alive_);
  }
  stats_.samples += static_cast<std::uint64_t>(count);
}

void LightTracer::advance(int depth) {
  intersect();
  shade(depth);
  trace_connections();
}

void LightTracer::intersect() {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  trace_nearest(scene_.accel, arrays_of(paths_.origin, paths_.direction, times_of(paths_.time)), alive_,
                scene_.traversal(), static_cast<std::int32_t>(scene_.shapes.shapes.size()), arrays_of(hits_));
}

void LightTracer::shade(int depth) {
  const StageTimer timer(stats_.times, Stage::kShading);
  int kept = 0;
  for (int i = 0; i < alive_; i += kWidth) {
    const Mask active = Mask::first(alive_ - i);
    const Hit found{Float::load(hits_.t + i),
                    Float::load(hits_.u + i),
                    Float::load(hits_.v + i),
                    Int::load(hits_.primitive + i),
                    Int::load(hits_.shape + i),
                    Int::load(hits_.instance + i),
                    scene_.any_motion ? Float::load(paths_.time + i) : Float(0.0f)};
    const Mask hit = active & (found.shape >= 0);
    if (none(hit)) continue;
    const Vec3 direction = paths_.direction.load(i);
    const Int slot = Int::load(paths_.slot + i);
    Vertex v{found.time,
             -direction,
             paths_.beta.load(i),
             slot,
             Sampler(scene_.sampler.kind, gather(pixel_hash_, slot, active), gather(reversed_sample_, slot, active)),
             kFirstEvent + depth * kPairsPerEvent,
             surface_at(scene_.shapes, found, paths_.origin.load(i), direction, hit, scene_.any_tangents),
             {}};
    interact(scene_, v.surface, v.to_light, v.sampler.get_2d(v.first_pair + kRoulette).y, hit, v.at);
    if (scene_.any_opacity) make_partly_opaque(v, hit);
    join_to_camera(v, hit);
    if (depth + 1 < scene_.max_depth) scatter_paths(v, hit, i, kept);
  }
  alive_ = kept;
}

void LightTracer::make_partly_opaque(Vertex& v, Mask hit) {
  const Mask partly = hit & ((v.at.flags & kHasOpacity) != 0);
  if (none(partly)) return;
  const Float u = v.sampler.get_2d(v.first_pair + kLobe).y;
  const Mask open = partly & (u >= opacity_of(scene_, v.at.material, v.surface, partly));
  v.at.kind = select(open, Int(static_cast<std::int32_t>(BsdfKind::kInterface)), v.at.kind);
  v.at.flags = select(open, Int(kAllDelta), v.at.flags);
}

void LightTracer::join_to_camera(const Vertex& v, Mask hit) {
  const Mask wanted = hit & ((v.at.flags & kAllDelta) == 0);
  if (none(wanted)) return;
  const CameraConnection eye =
      connect_to_camera(scene_.camera, v.surface.p, v.sampler.get_2d(v.first_pair + kLens), v.time, wanted);
  const Mask seen = wanted & eye.valid & lands(eye.film);
  if (none(seen)) return;
  const Vec3 to_eye = eye.lens - v.surface.p;
  const Float distance = length(to_eye);
  const Vec3 w = to_eye * (1.0f / max(distance, 1e-30f));
  // Radiance towards the eye of light that comes from where the path comes from; the cosine at the light's side is the
  // shading normal's, so the geometric one takes its place.
  const BsdfEval bsdf = eval_bsdf(v.at, w, v.to_light, seen);
  const Float geometry = eye.importance * abs(dot(w, v.surface.ng)) / max(abs(dot(v.to_light, v.surface.ng)), 1e-6f);
  const Spectrum value = v.beta * bsdf.f_cos * (geometry * scene_.exposure);
  Mask shines = and_not(seen, is_black(value));
  for (int c = 0; c < kSpectrumLanes; ++c) shines &= is_summable(value.c[c]);

  const Vec3 origin = offset_origin(v.surface, w);
  const Vec3 rest = eye.lens - origin;
  const Float length_left = length(rest);
  // What stands before the near plane is not seen, and blocks nothing.
  const float near_clip = scene_.camera.near_clip;
  const Float visible = near_clip > 0 ? length_left * (1.0f - near_clip / max(eye.depth, 1e-30f)) : length_left;
  const int at = connections_.size;
  connections_.origin.append(origin, shines, at);
  connections_.direction.append(rest * (1.0f / max(length_left, 1e-30f)), shines, at);
  compress_store(visible, shines, connections_.distance + at);
  if (scene_.any_motion) compress_store(v.time, shines, connections_.time + at);
  connections_.contribution.append(value, shines, at);
  compress_store(eye.film.x, shines, film_x_ + at);
  compress_store(eye.film.y, shines, film_y_ + at);
  connections_.size += count(shines);
}

Mask LightTracer::lands(Vec2 film) const {
  const float rx = scene_.filter.x.radius, ry = scene_.filter.y.radius;
  return (film.x > static_cast<float>(tile_.x0) - rx) & (film.x < static_cast<float>(tile_.x1) + rx) &
         (film.y > static_cast<float>(tile_.y0) - ry) & (film.y < static_cast<float>(tile_.y1) + ry);
}

void LightTracer::scatter_paths(const Vertex& v, Mask hit, int i, int& kept) {
  const BsdfSample bsdf = sample_bsdf(v.at, v.to_light, v.sampler.get_2d(v.first_pair + kLobe).x,
                                      v.sampler.get_2d(v.first_pair + kScatter), hit);
  // The weight is that of radiance along the path's other way; what carries flux is its adjoint.
  const Float normals = normal_ratio(v.surface, v.at.frame, v.to_light, bsdf.wi);
  const Float transport = normals * select(bsdf.transmission, sqr(bsdf.eta), Float(1.0f));
  Spectrum beta = v.beta * bsdf.weight * transport;
  const Float inverse_start = Float::load(inverse_start_ + i);
  Mask alive = and_not(hit & bsdf.valid & is_finite(beta), is_black(beta));
  const Float survival = clamp(beta.max_component() * inverse_start * kRouletteCaution, 0.05f, 1.0f);
  alive &= v.sampler.get_2d(v.first_pair + kRoulette).x < survival;
  beta *= 1.0f / survival;

  // Entries are read 16 at a time before they are overwritten, and never move up.
  paths_.origin.append(offset_origin(v.surface, bsdf.wi), alive, kept);
  paths_.direction.append(bsdf.wi, alive, kept);
  paths_.beta.append(beta, alive, kept);
  compress_store(inverse_start, alive, inverse_start_ + kept);
  if (scene_.any_motion) compress_store(v.time, alive, paths_.time + kept);
  kept += compress_store(v.slot, alive, paths_.slot + kept);
}

void LightTracer::trace_connections() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  trace_shadow(scene_.accel, arrays_of(connections_.origin, connections_.direction, times_of(connections_.time)),
               connections_.size, scene_.traversal(), connections_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(connections_.size);
  for (int i = 0; i < connections_.size; ++i) {
    if (connections_.distance[i] < 0) continue;
    const float value[3] = {connections_.contribution.c[0][i], connections_.contribution.c[1][i],
                            connections_.contribution.c[2][i]};
    splat(film_x_[i], film_y_[i], value);
  }
  connections_.size = 0;
}

void LightTracer::splat(float x, float y, const float (&value)[3]) {
  const PixelFilterRecord& filter = scene_.filter;
  // Pixels whose filters reach the place, which lands() has seen to be near the tile.
  const auto first = [](float place, float radius, std::uint32_t begin) {
    return std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(place - radius - 0.5f)), begin);
  };
  const auto last = [](float place, float radius, std::uint32_t end) {
    return std::min<std::int64_t>(static_cast<std::int64_t>(std::floor(place + radius - 0.5f)), std::int64_t{end} - 1);
  };
  const std::int64_t first_x = first(x, filter.x.radius, tile_.x0), last_x = last(x, filter.x.radius, tile_.x1);
  const std::int64_t first_y = first(y, filter.y.radius, tile_.y0), last_y = last(y, filter.y.radius, tile_.y1);
  for (std::int64_t py = first_y; py <= last_y; ++py) {
    const float wy = filter_value(filter.kind, filter.y, y - static_cast<float>(py) - 0.5f);
    for (std::int64_t px = first_x; px <= last_x; ++px) {
      const float weight = wy * filter_value(filter.kind, filter.x, x - static_cast<float>(px) - 0.5f);
      const auto pixel = static_cast<std::size_t>((py - tile_.y0) * (tile_.x1 - tile_.x0) + (px - tile_.x0));
      for (std::size_t c = 0; c < 3; ++c) planes_[c * stride_ + pixel] += value[c] * weight;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA

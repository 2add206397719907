#include "render/transport/vertex/ghost_light.h"

#include <algorithm>
#include <utility>

#include "render/film/summable.h"
#include "render/light/area/interpolated_normal.h"
#include "render/sensor/lens_entry.h"
#include "render/sensor/shutter.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/film_reach.h"
#include "render/transport/vertex/light_choice.h"
#include "render/transport/vertex/light_spectrum.h"
#include "render/transport/vertex/pass_share.h"

namespace tessera::render::TESSERA_ISA {

namespace {

// Pairs of dimensions beyond those of all paths; time and wavelength are those of kTime.
constexpr int kLensEntry = 14 << 20, kGhostLight = kLensEntry + 1, kGhostChoice = kLensEntry + 2;
static_assert(dimension::kLightLayerLobes + dimension::kDeepest < kLensEntry);

class WithGhostLight final : public Integrator {
 public:
  WithGhostLight(const IntegratorContext& context, std::unique_ptr<Integrator> algorithm)
      : algorithm_(std::move(algorithm)), ghosts_(context) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override {
    return algorithm_->render(work, film, stop) && ghosts_.trace(work.pass(), film, stop);
  }

 private:
  const std::unique_ptr<Integrator> algorithm_;
  GhostLight ghosts_;
};

}  // namespace

std::unique_ptr<Integrator> with_ghost_light(const IntegratorContext& context,
                                             std::unique_ptr<Integrator> algorithm) {
  if (!sends_light_into_lens(context.scene)) return algorithm;
  return std::make_unique<WithGhostLight>(context, std::move(algorithm));
}

bool sends_light_into_lens(const SceneTables& scene) {
  return takes_light(scene.sensor) && samples_lights(scene.lights);
}

bool GhostLight::trace(std::uint32_t pass, Film& film, std::stop_token stop) {
  const FilmRect rect = film.rect();
  const std::int32_t count = scene_.sensor.width * scene_.sensor.height;
  for (std::int32_t first = 0; first < count; first += kBatch) {
    if (stop.stop_requested()) return false;
    const std::int32_t batch = std::min<std::int32_t>(kBatch, count - first);
    for (std::int32_t at = 0; at < batch; at += kWidth)
      send(bit_cast<std::uint32_t>(Int::iota(first + at)), pass, rect, Mask::first(batch - at));
    joins_.trace(film);
  }
  return true;
}

void GhostLight::send(UInt index, std::uint32_t pass, const FilmRect& rect, Mask active) {
  constexpr std::uint32_t kSalt = 0x47686f73u;
  const UInt hash_of_ray = Sampler::pixel_hash(seed_, index, UInt(kSalt)),
             reversed = reverse_bits(UInt(pass));
  const Sampler numbers(scene_.sampler.kind, hash_of_ray, reversed);
  Float time(0.0f);
  if (scene_.any_motion) time = time_of_light(scene_.sensor, numbers.get_2d(dimension::kTime).x);
  const LensEntry entry = sample_lens_entry(scene_.sensor, numbers.get_2d(kLensEntry), time);
  const Vec2 choice = numbers.get_2d(kGhostChoice);
  Receiver at_lens(entry.point);
  at_lens.time = time;
  const auto [pick, sample] =
      choose_light(scene_.lights, at_lens, numbers.get_2d(kGhostLight), choice.x, active);
  const Mask shines = pick.picked & sample.valid;
  if (none(shines)) return;

  WidePath path{};
  path.wavelengths = wavelengths_of(scene_, numbers, {});
  path.dispersed = Int(0);
  const LensLanding landing =
      send_into_lens(scene_.sensor, entry, sample.wi, choice.y,
                     first_wavelength(path.wavelengths, Float(kMiddleNm)), time, shines);
  const Mask landed = shines & landing.valid & lands(scene_, landing.raster, rect);
  if (none(landed)) return;
  const Float pdf = sample.pdf * pick.pmf;
  const Float weight = select(sample.delta, Float(1.0f), power_heuristic(pdf, landing.pdf));
  path.beta = spectrum_of_light(scene_, spectra_of(scene_, path), pick.light, sample.radiance, landed);
  path.beta *= landing.value * weight * (scene_.sensor.response.exposure / select(landed, pdf, 1.0f));
  if (scene_.any_motion && scene_.sensor.shutter)
    path.beta *= exposure_at(scene_.sensor, landing.raster, time);
  if constexpr (kSpectral) {
    // The lens sends no other where the first one goes.
    end_other_wavelengths(Mask::all(), path);
  } else {
    path.beta.c[0] = path.beta.c[0] * landing.tint.x;
    path.beta.c[1] = path.beta.c[1] * landing.tint.y;
    path.beta.c[2] = path.beta.c[2] * landing.tint.z;
  }
  if (scene_.lights.any_interpolated) {
    path.beta *=
        interpolated_normal_factor(scene_.lights, pick.light, entry.point, sample, landing.pdf, landed);
  }
  Mask bright = and_not(landed, is_black(path.beta));
  for (int c = 0; c < kSpectrumLanes; ++c) bright &= is_summable(path.beta.c[c]);

  WideConnection ray{};
  ray.origin = entry.point;
  ray.direction = sample.wi;
  ray.distance = sample.distance;
  ray.contribution = path.beta;
  ray.time = time;
  ray.medium = Int(scene_.sensor.medium);
  ray.key = bit_cast<std::int32_t>(hash(hash_of_ray, reversed));
  ray.layers = Int(0);
  ray.inverse_weight = Float(1.0f);
  ray.wavelengths = path.wavelengths;
  joins_.add(ray, landing.raster, bright);
}

}  // namespace tessera::render::TESSERA_ISA

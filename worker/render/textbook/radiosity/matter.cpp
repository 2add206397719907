#include "render/textbook/radiosity/matter.h"

#include <algorithm>

#include "render/color/spectrum.h"
#include "render/core/constants.h"
#include "render/integrator/interaction.h"
#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// Sixteen points of patches, as rays find them that come down on their sides.
struct alignas(64) Points {
  float origin[3][kWidth] = {}, direction[3][kWidth] = {}, t[kWidth] = {}, u[kWidth] = {}, v[kWidth] = {};
  std::int32_t primitive[kWidth] = {}, shape[kWidth] = {}, instance[kWidth] = {};

  void set(int lane, const Surfaces& surfaces, Name name, const Weights& in_patch) {
    const Patch patch = surfaces.patch(name);
    const Corners corners = corners_of(name);
    Weights at;
    for (int corner = 0; corner < 3; ++corner) {
      for (int i = 0; i < 3; ++i) at.w[i] += in_patch.w[corner] * corners.at[corner].w[i];
    }
    const Vec p = patch.point(in_patch);
    const double distance = patch.radius();
    for (std::size_t i = 0; i < 3; ++i) {
      origin[i][lane] = static_cast<float>(p[i] + patch.normal[i] * distance);
      direction[i][lane] = static_cast<float>(-patch.normal[i]);
    }
    t[lane] = static_cast<float>(distance);
    u[lane] = static_cast<float>(at.w[1]), v[lane] = static_cast<float>(at.w[2]);
    const Surfaces::Origin from = surfaces.origin(name.side());
    primitive[lane] = from.primitive, shape[lane] = from.shape, instance[lane] = from.instance;
  }
  Vec3 load(const float (&lanes)[3][kWidth]) const {
    return {Float::load(lanes[0]), Float::load(lanes[1]), Float::load(lanes[2])};
  }
};

/// Adds reflectance and emission at the points of the first `n` lanes to the patches, `share` each.
void add_matter(const SceneTables& scene, const Points& points, int n, float share,
                Matter* const (&to)[kWidth]) {
  const Mask active = Mask::first(n);
  const Vec3 d = points.load(points.direction), wo = -d;
  const Hit hit{Float::load(points.t),       Float::load(points.u),   Float::load(points.v),
                Int::load(points.primitive), Int::load(points.shape), Int::load(points.instance)};
  const Surface surface =
      surface_at(scene.shapes, hit, points.load(points.origin), d, active, scene.any_tangents);
  Interaction at;
  interact(scene, surface, wo, Float(0.5f), Spectra(), active, at);
  const Spectrum reflectance = clamp(albedo_of(at, active), 0.0f, 1.0f);
  Spectrum emission(0.0f);
  if (const Mask lit = active & (surface.light >= 0); any(lit))
    emission = select(lit, emitted_radiance(scene.lights, surface.light, surface, wo, lit) * kPi, emission);
  for (int band = 0; band < kBands; ++band) {
    alignas(64) float own[kWidth], emitted[kWidth];
    reflectance.c[band].store(own);
    emission.c[band].store(emitted);
    for (int i = 0; i < n; ++i) {
      to[i]->reflectance.band[band] += share * own[i];
      to[i]->emission.band[band] += share * emitted[i];
    }
  }
}

}  // namespace

std::vector<Matter> matter_of(const SceneTables& scene, const Surfaces& surfaces,
                              std::span<const Name> patches) {
  // The middles of the four parts of a patch; one for all where nothing changes over it.
  constexpr Weights kFour[] = {{{2 / 3.0, 1 / 6.0, 1 / 6.0}},
                               {{1 / 6.0, 2 / 3.0, 1 / 6.0}},
                               {{1 / 6.0, 1 / 6.0, 2 / 3.0}},
                               {{1 / 3.0, 1 / 3.0, 1 / 3.0}}};
  const bool textured = scene.any_textures || scene.lights.any_textures;
  const std::size_t each = textured ? 4 : 1, total = patches.size() * each;
  std::vector<Matter> result(patches.size());
  for (std::size_t first = 0; first < total; first += kWidth) {
    Points points;
    Matter* to[kWidth] = {};
    const int n = static_cast<int>(std::min<std::size_t>(kWidth, total - first));
    for (int i = 0; i < n; ++i) {
      const std::size_t at = first + static_cast<std::size_t>(i);
      points.set(i, surfaces, patches[at / each], kFour[textured ? at % each : 3]);
      to[i] = &result[at / each];
    }
    add_matter(scene, points, n, 1.0f / static_cast<float>(each), to);
  }
  return result;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity

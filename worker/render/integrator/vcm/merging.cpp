#include "render/integrator/vcm/merging.h"

#include <algorithm>
#include <cmath>

#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Most subpaths whose vertices are kept at a time: 48 bytes a vertex, twice while they are sorted.
constexpr std::int64_t kMostPhotonPaths = 1 << 20;

/// Radius of the first pass over the scene's: as large as in [Georgiev 2012]'s program.
constexpr float kRadiusOfScene = 0.003f;

/// Squared radii fall with the pass to the power of this less one [Knaus & Zwicker 2011].
constexpr double kAlpha = 2.0 / 3;

}  // namespace

Merging::Merging(const SceneTables& scene, float first_radius)
    : scene_(scene),
      first_radius_(first_radius > 0 ? first_radius : kRadiusOfScene * scene.lights.scene_radius) {
  const std::int64_t pixels = std::int64_t{scene.camera.width} * scene.camera.height;
  stride_ = static_cast<std::uint32_t>((pixels + kMostPhotonPaths - 1) / kMostPhotonPaths);
  for (std::int64_t first = 0; first < pixels; first += std::int64_t{kSubpaths} * stride_)
    photon_paths_ += std::min<std::int64_t>(kSubpaths, pixels - first);
}

void Merging::begin(std::uint32_t pass) {
  radius_ = first_radius_ * static_cast<float>(std::pow(pass + 1.0, (kAlpha - 1) / 2));
  map_.clear();
}

float Merging::area() const { return kPi * radius_ * radius_; }

void Merging::add(const LightVertex& vertices, int event) {
  const Vertex& v = vertices.vertex;
  const double pixels = static_cast<double>(scene_.camera.width) * scene_.camera.height;
  const auto share = static_cast<float>(pixels / static_cast<double>(photon_paths_));
  map_.append(
      {v.surface.p, v.wo, vertices.beta * share, vertices.weights.last, vertices.weights.rest, Int(event)},
      and_not(vertices.joinable, v.in_medium));
}

Spectrum Merging::gather(const Vertex& at, const PartialWeights& eye, int depth, Mask active) const {
  Spectrum sum(0.0f);
  const Float inverse_photons(1.0f / photons_a_join());
  map_.for_each_near(at.surface.p, active, [&](const auto& photon, Mask near) {
    // The photon's events and those of the path from the eye, this one among them.
    near &= photon.event + depth < scene_.max_depth;
    if (none(near)) return;
    const BsdfEval scattered = eval_scattering(scene_, at, photon.direction, near);
    // Flux by area, under the true normal.
    const Float cosine = max(cosine_at(at, photon.direction), 1e-6f);
    Spectrum light = scattered.f_cos * photon.flux * (1.0f / cosine);
    const Float back = eval_scattering(scene_, at, photon.direction, at.wo, near, Transport::kImportance).pdf;
    const PartialWeights from_light{photon.last, photon.rest};
    light *= weight_of_way(from_light.ways(inverse_photons, scattered.pdf, Float(0.0f)),
                           eye.ways(inverse_photons, back, Float(0.0f)));
    sum += select_or_zero(near & is_finite(light), light);
  });
  return sum * (1.0f / area());
}

}  // namespace tessera::render::TESSERA_ISA

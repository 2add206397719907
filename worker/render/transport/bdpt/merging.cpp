#include "render/transport/bdpt/merging.h"

#include <algorithm>
#include <cmath>

#include "render/core/constants.h"
#include "render/integrator/algorithm_list.h"
#include "render/transport/bdpt/bidirectional.h"
#include "render/transport/photon_map/photon_steps.h"
#include "render/transport/photon_map/radius_of_pass.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/ghost_light.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Radius of the first pass over the scene's: as large as in [Georgiev 2012]'s program.
constexpr float kRadiusOfScene = 0.003f;

}  // namespace

Merging::Merging(const SceneTables& scene, float first_radius)
    : scene_(scene),
      first_radius_(first_radius > 0 ? first_radius : kRadiusOfScene * scene.lights.scene_radius) {}

void Merging::expect(double photons_a_path) {
  const std::int64_t pixels = std::int64_t{scene_.sensor.width} * scene_.sensor.height;
  const double passes = std::ceil(photons_a_path * static_cast<double>(pixels) / kMostPhotons);
  stride_ = static_cast<std::uint32_t>(std::max(1.0, passes));
  photon_paths_ = 0;
  for (std::int64_t first = 0; first < pixels; first += std::int64_t{kSubpaths} * stride_)
    photon_paths_ += std::min<std::int64_t>(kSubpaths, pixels - first);
}

void Merging::begin(std::uint32_t pass) {
  radius_ = radius_of_pass(first_radius_, pass);
  map_.clear();
}

float Merging::area() const { return kPi * radius_ * radius_; }

void Merging::add(const LightVertex& vertices, int event) {
  const Vertex& v = vertices.vertex;
  const double pixels = static_cast<double>(scene_.sensor.width) * scene_.sensor.height;
  const auto share = static_cast<float>(pixels / static_cast<double>(photon_paths_));
  map_.append({.position = v.surface.p,
               .direction = v.wo,
               .flux = vertices.beta * share,
               .last = vertices.weights.last,
               .rest = vertices.weights.rest,
               .steps = photon_steps(event, tells_layers(scene_) ? vertices.layer_state : Int(0),
                                     disperses(scene_) ? vertices.dispersed : Int(0))},
              and_not(vertices.joinable, v.in_medium));
}

Spectrum Merging::gather(const Vertex& at, const PartialWeights& eye, int depth, Int dispersed, Mask active,
                         GatheredLayers* layers) const {
  Spectrum sum(0.0f);
  const Float inverse_photons(1.0f / photons_a_join());
  map_.for_each_near(at.surface.p, active, [&](const auto& photon, Mask near) {
    // The photon's events and those of the path from the eye, this one among them.
    near &= has_fewer_events(photon.steps, scene_.max_depth - depth);
    if (none(near)) return;
    const BsdfEval scattered = eval_scattering(scene_, at, photon.direction, near);
    // Flux by area, under the true normal.
    const Float cosine = max(cosine_at(at, photon.direction), 1e-6f);
    Spectrum light = scattered.f_cos * photon.flux * (1.0f / cosine);
    if (disperses(scene_)) light *= joined_factor(dispersed, dispersed_of(photon.steps));
    const Float back = eval_scattering(scene_, at, photon.direction, at.wo, near, Transport::kImportance).pdf;
    const PartialWeights from_light{photon.last, photon.rest};
    light *= weight_of_way(from_light.ways(inverse_photons, scattered.pdf, Float(0.0f)),
                           eye.ways(inverse_photons, back, Float(0.0f)));
    const Mask counts = near & is_finite(light);
    sum += select_or_zero(counts, light);
    if (layers != nullptr) layers->add(at, light, photon.direction, layer_state_of(photon.steps), counts);
  });
  if (layers != nullptr) layers->sums.scale(Spectrum(1.0f / area()));
  return sum * (1.0f / area());
}

std::unique_ptr<Integrator> make_vcm(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return with_ghost_light(context, std::make_unique<Bidirectional>(context, StrategyFilter{},
                                                                   std::make_unique<Merging>(context.scene)));
}

const ListedAlgorithm vcm{{"vcm", &make_vcm}};

}  // namespace tessera::render::TESSERA_ISA

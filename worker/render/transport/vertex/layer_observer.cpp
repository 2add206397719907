#include "render/transport/vertex/layer_observer.h"

#include "render/integrator/stage_timer.h"
#include "render/light/light_access.h"
#include "render/light/selection/pick.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_spectrum.h"
#include "render/transport/vertex/partial_weights.h"
#include "render/transport/vertex/power_heuristic.h"

namespace tessera::render::TESSERA_ISA {

std::unique_ptr<LayerObserver> make_layer_observer(const IntegratorContext& context, SampleBatch& batch) {
  return tells_layers(context.scene) ? std::make_unique<LayerObserver>(context, batch) : nullptr;
}

void LayerObserver::emitted(const Encounter& e, MetLight& light) {
  const Int layers = layers_at_light(scene_.layers, e.path.layer_state, light.light, light.lanes);
  batch_.add_to_layers(light.arriving * e.path.beta, layers, e.path.slot, light.lanes);
}

void LayerObserver::lit(const Encounter& e, SampledLight& light) {
  const Mask shines = and_not(light.lanes, is_black(light.ray.contribution));
  const Int state = state_behind(e, light.sample.wi, shines);
  light.ray.layers = layers_at_light(scene_.layers, state, light.light, shines);
  if (shadows_) look_for_shadow(e, light, state, shines);
}

void LayerObserver::scattered(const Encounter& e, Scattering& s) {
  s.next.layer_state = state_after(scene_, e.vertex, e.path.layer_state, e.vertex.wo, s.bsdf.wi,
                                   s.bsdf.specular, {e.numbers, e.depth, false}, s.alive);
  if (shadows_) look_for_shadow_of_sky(e, s, and_not(joinable(e.vertex, s.alive), s.bsdf.specular));
}

void LayerObserver::all_scattered(int depth) {
  if (!shadows_) return;
  const StageTimer timer(stats_.times, Stage::kShadow);
  shadows_->trace(batch_, depth);
}

/// The state of the automaton behind the vertex, for light that comes along `wi` and is scattered there.
Int LayerObserver::state_behind(const Encounter& e, Vec3 wi, Mask lanes) const {
  return state_after(scene_, e.vertex, e.path.layer_state, e.vertex.wo, wi, Mask::none(),
                     {e.numbers, e.depth, true}, lanes);
}

/// A sampled light tells all of its shadow, but that of the sky, of which some is not sampled: that is
/// weighed as light is.
void LayerObserver::look_for_shadow(const Encounter& e, const SampledLight& light, Int state, Mask shines) {
  WideConnection ray = light.ray;
  const Mask sky = environment_lanes(scene_.lights, light.light, shines);
  ray.contribution = ray.contribution * select(sky, 1.0f, inverse_of(light.weight));
  ray.layers = shadows_at_light(scene_.layers, state, light.light, shines);
  shadows_->add(ray, shines, batch_, e.depth);
}

/// The other part of it: in the direction in which the path goes on.
void LayerObserver::look_for_shadow_of_sky(const Encounter& e, const Scattering& s, Mask lanes) {
  if (none(lanes)) return;
  const Vertex& v = e.vertex;
  const BsdfSample& bsdf = s.bsdf;
  const Int state = state_behind(e, bsdf.wi, lanes);
  const Receiver here = receiver_at(scene_, e);
  WideConnection ray =
      connect(scene_, v, bsdf.wi, fma(bsdf.wi, Float(kInfiniteDistance), v.surface.p), lanes);
  ray.slot = e.path.slot;
  // Apart from the numbers on the way to sampled lights.
  if (scene_.volumetric) {
    ray.key = bit_cast<std::int32_t>(hash(batch_.key(ray.slot, lanes) ^ 0x536b7921u));
    ray.wavelengths = e.path.wavelengths;
  }
  for (const std::int32_t light : scene_.lights.infinite_lights) {
    const Float pdf = light_pdf(scene_.lights, Int(light), here, bsdf.wi, v.surface.p, bsdf.wi, lanes) *
                      pick_pmf(scene_.lights, Int(light), here, lanes);
    ray.contribution = environment_light(scene_, spectra_of(scene_, e.path), light, here, bsdf.wi, lanes) *
                       power_heuristic(bsdf.pdf, pdf) * s.next.beta;
    ray.layers = shadows_at_light(scene_.layers, state, Int(light), lanes);
    shadows_->add(ray, lanes, batch_, e.depth);
  }
}

}  // namespace tessera::render::TESSERA_ISA

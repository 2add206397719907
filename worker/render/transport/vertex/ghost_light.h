// Ghosts of lights, by light tracing: a place of the lens is lit by a sampled light, and what it sends there
// is followed over two reflections to the film. That finds lamps and the sun, which rays from the film hardly
// meet; what those meet is weighed against it by the power heuristic [Veach 1997].
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "render/integrator/algorithm_list.h"
#include "render/integrator/integrator.h"
#include "render/light/selection/pick.h"
#include "render/transport/vertex/power_heuristic.h"
#include "render/transport/vertex/sensor_joins.h"

namespace tessera::render::TESSERA_ISA {

/// Whether algorithms that work in passes are to add such light.
bool sends_light_into_lens(const SceneTables& scene);

class GhostLight {
 public:
  explicit GhostLight(const IntegratorContext& context)
      : scene_(context.scene), seed_(context.seed), joins_(context) {}

  /// Sends as much light into the lens as the film has pixels, wherever it lands: that of one pass. False
  /// when stopped.
  bool trace(std::uint32_t pass, Film& film, std::stop_token stop);

 private:
  void send(UInt index, std::uint32_t pass, const FilmRect& rect, Mask active);

  const SceneTables& scene_;
  const std::uint64_t seed_;
  SensorJoins joins_;
};

/// The weight of light of a lamp, or of the sky, that a ray of the sensor meets first, against light that is
/// sent in: `ray_pdf` is its SensorRay::pdf. `point` and `normal` are those of a lamp.
TESSERA_INLINE Float weight_against_ghost_light(const SceneTables& scene, Float ray_pdf, const Receiver& from,
                                                Vec3 direction, Int light, Vec3 point, Vec3 normal,
                                                Mask lit) {
  const Mask weighed = lit & (ray_pdf > 0.0f);
  if (none(weighed)) return Float(1.0f);
  const Float by_lights = light_pdf(scene.lights, light, from, direction, point, normal, weighed) *
                          pick_pmf(scene.lights, light, from, weighed);
  return select(weighed, power_heuristic(ray_pdf, by_lights), 1.0f);
}

/// An algorithm that works in passes, to which such light is added where there is any. What its rays from the
/// sensor meet first it weighs by SensorRay::pdf.
std::unique_ptr<Integrator> with_ghost_light(const IntegratorContext& context,
                                             std::unique_ptr<Integrator> algorithm);
/// Algorithm::make.
template <class T>
std::unique_ptr<Integrator> make_with_ghost_light(const IntegratorContext& context) {
  return with_ghost_light(context, make<T>(context));
}

}  // namespace tessera::render::TESSERA_ISA

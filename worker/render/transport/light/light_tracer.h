// Light tracing: paths begin at the lights, and every point that they are scattered at is joined to the
// camera [Arvo 1986; Dutre, Lafortune & Willems 1993]. What it finds easily, caustics above all, is what path
// tracing hardly finds, and the other way round: surfaces seen in a mirror stay black.
//
// A pass traces as many paths as the film has pixels; they may land anywhere on it. Lights that the camera
// sees directly are added by camera rays.
#pragma once

#include <stop_token>

#include "render/integrator/integrator.h"
#include "render/transport/path/wavefront.h"
#include "render/transport/vertex/light_paths.h"
#include "render/transport/vertex/sensor_joins.h"

namespace tessera::render::TESSERA_ISA {

class LightTracer final : public Integrator {
 public:
  explicit LightTracer(const IntegratorContext& context)
      : scene_(context.scene),
        eye_(context, 0),
        paths_(context, static_cast<float>(context.scene.sensor.width) *
                            static_cast<float>(context.scene.sensor.height)),
        joins_(context) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  void join_to_sensor(const LightEvent& e, Mask hit, const FilmRect& rect);

  const SceneTables& scene_;
  Wavefront eye_;  // finds the lights that are seen directly
  LightPaths paths_;
  SensorJoins joins_;
};

}  // namespace tessera::render::TESSERA_ISA

#include "render/transport/vertex/light_end.h"

#include "render/light/emission.h"
#include "render/light/light_access.h"
#include "render/light/selection/pick.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Lanes whose light only light sampling and emission find; of these, those whose light a receiver sees in
/// one direction; and of these, those where it has a place.
struct DeltaLights {
  Mask delta = Mask::none(), single = Mask::none(), at_a_point = Mask::none();

  DeltaLights(const LightTable& table, Int light, Mask active) {
    for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
      const LightTraits& traits = light_model(static_cast<LightKind>(kind)).traits;
      if (!traits.delta) return;
      delta |= lanes;
      if (traits.extended) return;
      single |= lanes;
      if (!traits.at_infinity) at_a_point |= lanes;
    });
  }
};

}  // namespace

Mask delta_lights(const LightTable& table, Int light, Mask active) {
  return DeltaLights(table, light, active).delta;
}

LightEnd light_end(const LightTable& table, Int light, Float time, Float pdf, Vec3 point, Float cosine,
                   Vec3 direction, Float distance_squared, Mask active) {
  const EmissionDensity emission = emission_density(table, light, time, point, cosine, direction, active);
  const DeltaLights lights(table, light, active);
  LightEnd end;
  // Places are infinitely dense on the disk around a scene of one point, whose sky starts no path.
  const Float pmf = discrete_pmf(table.selection, light, active);
  end.emitted =
      select_or_zero(pmf > 0.0f, pmf * (emission.place * UnitArea(table).size) * emission.direction);
  end.sampled = pdf * abs(cosine) * select(lights.at_a_point, distance_squared, 1.0f);
  end.hit = select_or_zero(~lights.delta, abs(cosine));
  return end;
}

Float sampling_density(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point,
                       Vec3 normal, Mask active) {
  const DeltaLights lights(table, light, active);
  const Mask spread = and_not(active, lights.single);
  const Float pdf = light_pdf(table, light, from, wi, point, normal, spread);
  return select(lights.single, 1.0f, pdf) * pick_pmf(table, light, from, active);
}

}  // namespace tessera::render::TESSERA_ISA

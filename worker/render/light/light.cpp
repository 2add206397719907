#include "render/light/light.h"

#include <array>

#include "render/light/light_access.h"
#include "render/light/models.h"

namespace tessera::render::TESSERA_ISA {
namespace {

Int kind_of(const LightTable& table, Int light, Mask active) {
  static_assert(sizeof(LightKind) == sizeof(std::int32_t));
  const auto* kinds = reinterpret_cast<const std::int32_t*>(&table.lights.data()->kind);
  return gather(kinds, light * static_cast<std::int32_t>(sizeof(LightRecord) / 4), active);
}

LightSample no_sample() {
  return {{0.0f, 0.0f, 1.0f}, Float(0.0f), Spectrum(0.0f), Float(0.0f), Mask::none(), Mask::none()};
}

}  // namespace

const LightModel& light_model(LightKind kind) {
  static const std::array<const LightModel*, static_cast<std::size_t>(LightKind::kCount)> models = {
      &point_light(),    &spot_light(),   &distant_light(), &infinite_light(),
      &triangle_light(), &sphere_light(), &disk_light()};
  return *models[static_cast<std::size_t>(kind)];
}

LightSample sample_light(const LightTable& table, Int light, Vec3 reference, Vec2 u, Mask active) {
  LightSample result = no_sample();
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    const LightSample one = light_model(static_cast<LightKind>(kind)).sample(table, light, reference, u, lanes);
    result = select(lanes, one, result);
  });
  return result;
}

Float light_pdf(const LightTable& table, Int light, Vec3 reference, Vec3 wi, Vec3 point, Vec3 normal, Mask active) {
  Float result(0.0f);
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    const LightModel& model = light_model(static_cast<LightKind>(kind));
    result = select(lanes, model.pdf(table, light, reference, wi, point, normal, lanes), result);
  });
  return result;
}

Spectrum emitted_radiance(const LightTable& table, Int light, Vec3 normal, Vec3 wo, Mask active) {
  const LightLanes lanes{table, light, active};
  return select_or_zero(lanes.shines_towards(normal, wo), lanes.radiance());
}

}  // namespace tessera::render::TESSERA_ISA

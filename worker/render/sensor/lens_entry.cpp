#include "render/sensor/lens_entry.h"

#include "render/sampling/discrete.h"
#include "render/sensor/model/lens_ghosts.h"
#include "render/sensor/pose.h"

namespace tessera::render::TESSERA_ISA {

bool takes_light(const SensorRecord& sensor) {
  return sensor.kind == SensorKind::kLensSystem && sensor.lens->ghosts.rays_of_lights > 0;
}

LensEntry sample_lens_entry(const SensorRecord& sensor, Vec2 u, Float time) {
  const LensTable& lens = *sensor.lens;
  const LensOpening opening = sample_opening(lens, lens.surfaces.back(), u);
  const WideAffine pose = pose_at(sensor, time);
  LensEntry entry{transform_vector(pose, opening.point * Float(lens.units_per_mm)), opening.point,
                  opening.normal};
  if (is_elsewhere(sensor)) entry.point = entry.point + place_of(pose);
  return entry;
}

LensLanding send_into_lens(const SensorRecord& sensor, const LensEntry& entry, Vec3 wi, Float u_bounce,
                           Float wavelength, Float time, Mask active) {
  const LensTable& lens = *sensor.lens;
  const GhostTable& ghosts = lens.ghosts;
  const WideAffine pose = pose_at(sensor, time);
  const auto along = [&](int a) { return dot(wi, normalize(Vec3{pose.m[a], pose.m[4 + a], pose.m[8 + a]})); };
  const Vec3 from = normalize(Vec3{along(0), along(1), along(2)});
  const DiscreteSample choice = sample_discrete(ghosts.selection, u_bounce, active);
  const LensColours colours = colours_of(sensor, sensor.disperses ? wavelength : Float(0.0f));
  LensRay ray{mirrored(entry.in_lens), mirrored(-from), active & (dot(from, entry.in_normal) > 0.0f)};
  const auto* const bounces = &ghosts.bounces.data()->near_film;
  LensLight light;
  follow_bounce(lens, LensWay::kToFilm, colours, gather(bounces, choice.index * 2, active),
                gather(bounces + 1, choice.index * 2, active), ray, light);
  ray.alive &= ray.direction.z > 1e-4f;
  const Float t = -ray.origin.z / max(ray.direction.z, 1e-4f);
  const Vec3 film{fma(ray.direction.x, t, ray.origin.x), fma(ray.direction.y, t, ray.origin.y), Float(0.0f)};

  LensLanding landing;
  landing.valid = ray.alive;
  const Float to_place = Float(-1 / lens.film_distance);
  landing.raster = {(film.x * to_place - sensor.offset_x) * (1 / sensor.scale_x),
                    (film.y * to_place - sensor.offset_y) * (1 / sensor.scale_y)};
  const Float across = opening_across(lens.surfaces.back(), entry.in_normal, from);
  const float pixel = pixel_area(sensor) * lens.film_distance * lens.film_distance;
  landing.value = select_or_zero(ray.alive, across / select(active, choice.pmf, 1.0f) *
                                                (ghosts.per_etendue / (pixel * ghosts.rays_of_lights)));
  landing.tint = light.part;
  if (colours.one) landing.value = landing.value * light.part.x;
  const Float etendue = film_etendue(lens, film, mirrored(ray.origin));
  landing.pdf = select_or_zero(ray.alive, rival_density(sensor, entry.in_lens, from, etendue));
  return landing;
}

}  // namespace tessera::render::TESSERA_ISA

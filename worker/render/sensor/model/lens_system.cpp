// Rays from the film through all surfaces of a lens [Kolb, Mitchell & Hanrahan 1995]. They start towards the
// part of a plane behind the lens that light comes through, which is known for each place of the film, so
// that few are blocked. The weight is the irradiance's: cos^4 times the area of that part over the square of
// its distance. Where the lens has ghosts, a part of the rays looks for those.
//
// Points of the scene are not connected to the film: which ray through the lens leads there is the solution
// of equations, none or several.
#include "render/sampling/discrete.h"
#include "render/sensor/model/flat_raster.h"
#include "render/sensor/model/lens_ghosts.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec2 film_point(const LensTable& lens, Vec2 place) {
  // The picture on the film is upside down.
  return {place.x * -lens.film_distance, place.y * -lens.film_distance};
}

struct PupilSample {
  Vec2 point;
  Float area;  // of the part of the plane in which points are sampled evenly; 0: no light comes there
};

PupilSample sample_pupil(const LensTable& lens, Vec2 film, Vec2 u) {
  Int cell;
  Vec2 axis{Float(1.0f), Float(0.0f)};
  if (lens.rings) {
    const Float radius = sqrt(sqr(film.x) + sqr(film.y)), inverse = 1.0f / max(radius, 1e-20f);
    const Mask aside = radius > 1e-12f;
    axis = {select(aside, film.x * inverse, 1.0f), select_or_zero(aside, film.y * inverse)};
    cell = to_int(min(radius * lens.cells_per_mm_x, static_cast<float>(lens.cells_x - 1)));
  } else {
    const auto index = [](Float x, float first, float per_mm, std::int32_t count) {
      return to_int(clamp((x - first) * per_mm, 0.0f, static_cast<float>(count - 1)));
    };
    cell = index(film.y, lens.first_y, lens.cells_per_mm_y, lens.cells_y) * lens.cells_x +
           index(film.x, lens.first_x, lens.cells_per_mm_x, lens.cells_x);
  }
  const float* const nodes = &lens.pupil.data()->x;
  constexpr std::int32_t kNodeFloats = 4, kArea = 3;
  static_assert(sizeof(PupilNode) == kNodeFloats * sizeof(float));
  const auto read = [&](Int node, std::int32_t member) {
    return gather(nodes, node * kNodeFloats + member, Mask::all());
  };
  const Int first = cell * kPupilNodes;
  PupilSample sample;
  sample.area = read(first + (kPupilNodes - 1), kArea);
  // The trapezoid, and the place along x within it, by area.
  const Float before = sample.area * u.x;
  Int low_node = first;
  for (std::int32_t step = (kPupilNodes - 1) / 2; step > 0; step /= 2) {
    const Int middle = low_node + step;
    low_node = select(read(middle, kArea) <= before, middle, low_node);
  }
  const Int high_node = low_node + 1;
  const Float low0 = read(low_node, 1), high0 = read(low_node, 2), low1 = read(high_node, 1),
              high1 = read(high_node, 2), area0 = read(low_node, kArea), area1 = read(high_node, kArea);
  const Float width0 = high0 - low0, width1 = high1 - low1;
  const Float part = clamp((before - area0) / max(area1 - area0, 1e-30f), 0.0f, 1.0f);
  const Float root = safe_sqrt(fma(part, sqr(width1) - sqr(width0), sqr(width0)));
  const Float t = min(part * (width0 + width1) / max(width0 + root, 1e-30f), 1.0f);
  const auto between = [&](Float a, Float b) { return fma(t, b - a, a); };
  const Float x = between(read(low_node, 0), read(high_node, 0));
  const Float low = between(low0, low1), high = between(high0, high1);
  const Float y = fma(u.y, high - low, low);
  sample.point = {x * axis.x - y * axis.y, x * axis.y + y * axis.x};
  return sample;
}

/// A ray that has left the lens, or was blocked by it.
LocalRay outside(const LensTable& lens, const LensRay& ray, Float weight) {
  const Vec3 forward{Float(0.0f), Float(0.0f), Float(1.0f)};
  LocalRay out;
  out.valid = ray.alive;
  out.origin = select(ray.alive, ray.origin * Float(lens.units_per_mm), forward * Float(0.0f));
  out.direction = select(ray.alive, ray.direction, forward);
  out.weight = weight;
  return out;
}

/// With what is left of its light.
void dim(const LensColours& colours, const LensLight& light, LocalRay& out) {
  if (colours.one) {
    out.weight = out.weight * light.part.x;
  } else {
    out.tint = light.part;
  }
}

/// A ray that is refracted by all surfaces, in the lanes `active`.
LocalRay refracted_ray(const LensTable& lens, const LensColours& colours, Vec2 film, Vec2 u, Mask active) {
  const PupilSample pupil = sample_pupil(lens, film, u);
  const Vec3 way{pupil.point.x - film.x, pupil.point.y - film.y, Float(lens.pupil_z)};
  LensRay ray{{film.x, film.y, Float(0.0f)}, normalize(way), active & (pupil.area > 0.0f)};
  Float weight = pupil.area * (sqr(sqr(ray.direction.z)) * lens.weight);
  const bool dims = lens.ghosts.part > 0;
  LensLight light;
  for (std::size_t i = 0; i < lens.surfaces.size() && any(ray.alive); ++i) {
    const LensSurfaceRecord& surface = lens.surfaces[i];
    if (dims) {
      meet_and_dim(lens, i, LensWay::kToScene, colours, ray.alive, Mask::none(), ray, light);
      continue;
    }
    const Vec3 normal = meet(lens, surface, LensWay::kToScene, ray);
    if (surface.is_stop != 0 && lens.picture.any()) weight = weight * stop_transmission(lens, surface, ray);
    if (surface.refracts != 0) refract(normal, at_wavelength(lens.ratios, lens, i, colours.place), ray);
  }
  LocalRay out = outside(lens, ray, weight);
  if (dims) dim(colours, light, out);
  return out;
}

/// A ray that two surfaces reflect, in the lanes `active`: from any place of the one next to the film.
LocalRay reflected_ray(const SensorRecord& sensor, const LensColours& colours, Vec2 film, Vec2 u,
                       Mask active) {
  const LensTable& lens = *sensor.lens;
  const GhostTable& ghosts = lens.ghosts;
  const DiscreteSample choice = sample_discrete(ghosts.selection, u.y, active);
  const LensOpening opening = sample_opening(lens, lens.surfaces.front(), {u.x, choice.u});
  const Vec3 from{film.x, film.y, Float(0.0f)}, way = opening.point - from;
  LensRay ray{from, normalize(way), active & (dot(way, opening.normal) > 0.0f)};
  const auto* const bounces = &ghosts.bounces.data()->near_film;
  LensLight light;
  follow_bounce(lens, LensWay::kToScene, colours, gather(bounces, choice.index * 2, active),
                gather(bounces + 1, choice.index * 2, active), ray, light);
  const Float etendue = film_etendue(lens, from, opening.point);
  LocalRay out =
      outside(lens, ray, etendue * ghosts.per_etendue / (select(active, choice.pmf, 1.0f) * ghosts.part));
  dim(colours, light, out);
  if (ghosts.rays_of_lights > 0)
    out.pdf = select_or_zero(ray.alive, rival_density(sensor, ray.origin, ray.direction, etendue));
  return out;
}

LocalRay ray_through(const SensorRecord& sensor, Vec2 place, Vec2 u, Float nm) {
  const LensTable& lens = *sensor.lens;
  const Vec2 film = film_point(lens, place);
  const LensColours colours = colours_of(sensor, nm);
  const float part = lens.ghosts.part;
  if (part == 0) return refracted_ray(lens, colours, film, u, Mask::all());
  const Mask reflected = u.x < part;
  LocalRay ray = refracted_ray(
      lens, colours, film, {clamp((u.x - part) * (1 / (1 - part)), 0.0f, kOneMinusEpsilon), u.y}, ~reflected);
  ray.weight = ray.weight * (1 / (1 - part));
  if (none(reflected)) return ray;
  const LocalRay ghost =
      reflected_ray(sensor, colours, film, {min(u.x * (1 / part), kOneMinusEpsilon), u.y}, reflected);
  return {
      select(reflected, ghost.origin, ray.origin), select(reflected, ghost.direction, ray.direction),
      select(reflected, ghost.weight, ray.weight), (reflected & ghost.valid) | and_not(ray.valid, reflected),
      select_or_zero(reflected, ghost.pdf),        select(reflected, ghost.tint, ray.tint)};
}

class LensSystemSensor final : public SensorModel {
 public:
  LensSystemSensor() : SensorModel({.has_lens = true, .connects = false, .may_fail = true, .weighs = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    return ray_through(sensor, place, u_lens, Float(0.0f));
  }
  LocalRay start_dispersed(const SensorRecord& sensor, Vec2 place, Vec2 u_lens,
                           Float wavelength) const override {
    return ray_through(sensor, place, u_lens, wavelength);
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<LensSystemSensor> lens_system(SensorKind::kLensSystem);

}  // namespace tessera::render::TESSERA_ISA

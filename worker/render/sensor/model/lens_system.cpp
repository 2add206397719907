// Rays from the film through all surfaces of a lens [Kolb, Mitchell & Hanrahan 1995]. They start towards the
// part of a plane behind the lens that light comes through, which is known for each place of the film, so
// that few are blocked. The weight is the irradiance's: cos^4 times the area of that part over the square of
// its distance.
//
// Points of the scene are not connected to the film: which ray through the lens leads there is the solution
// of equations, none or several.
#include "render/sensor/lens_table.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A ray within the lens, in millimetres; direction of unit length.
struct LensRay {
  Vec3 origin, direction;
  Mask alive;
};

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

/// A conic and a polynomial over the squared height, and its slope by that.
struct Sag {
  Float z, slope;
  Mask valid;
};
Sag sag_at(const LensTable& lens, const LensSurfaceRecord& surface, Float h2) {
  const float c = surface.curvature;
  const Float under = 1.0f - h2 * ((1 + surface.conic) * c * c);
  const Float root = sqrt(max(under, 1e-6f));
  Sag sag{c * h2 / (1.0f + root), c * 0.5f / root, under > 0.0f};
  Float power = h2;
  for (std::int32_t i = 0; i < surface.coefficients; ++i) {
    const float a = lens.coefficients[static_cast<std::size_t>(surface.first_coefficient + i)];
    sag.slope = fma(power, a * static_cast<float>(i + 2), sag.slope);
    power = power * h2;
    sag.z = fma(power, a, sag.z);
  }
  return sag;
}

/// Moves the ray to the surface, and gives the normal there, towards the scene.
Vec3 meet(const LensTable& lens, const LensSurfaceRecord& surface, LensRay& ray) {
  const Vec3 d = ray.direction;
  ray.alive &= d.z > 1e-4f;
  // Heights are counted from the vertex, so that they keep their digits.
  const Float to_vertex = (surface.z - ray.origin.z) / max(d.z, 1e-4f);
  Vec3 p{fma(d.x, to_vertex, ray.origin.x), fma(d.y, to_vertex, ray.origin.y), Float(0.0f)};
  Vec3 normal{Float(0.0f), Float(0.0f), Float(1.0f)};
  if (surface.shape != LensSurfaceShape::kPlane) {
    const bool cylinder = surface.shape == LensSurfaceShape::kCylinder;
    const auto across = [&](Float x, Float y) {
      if (!cylinder) return Vec2{x, y};
      const Float along = x * surface.straight_x + y * surface.straight_y;
      return Vec2{x - along * surface.straight_x, y - along * surface.straight_y};
    };
    const float c = surface.curvature, k = 1 + surface.conic;
    const Vec2 da = across(d.x, d.y), pa = across(p.x, p.y);
    // The root next to the vertex [Welford 1986, section 4.3].
    const Float qa = c * (sqr(da.x) + sqr(da.y) + k * sqr(d.z)), qb = d.z - c * (pa.x * da.x + pa.y * da.y),
                qc = c * (sqr(pa.x) + sqr(pa.y));
    const Float under = qb * qb - qa * qc;
    ray.alive &= under >= 0.0f;
    const Float root = sqrt(max(under, 0.0f));
    Float t = qc / max(qb + root, 1e-6f);
    if (surface.shape == LensSurfaceShape::kSphere) {
      p = fma(d, t, p);
      normal = {p.x * -c, p.y * -c, 1.0f - c * p.z};
    } else {
      // Newton's steps, which conics do not need.
      const int steps = surface.coefficients > 0 ? 5 : 0;
      for (int i = 0;; ++i) {
        const Vec3 at = fma(d, t, p);
        const Vec2 ha = across(at.x, at.y);
        const Sag sag = sag_at(lens, surface, sqr(ha.x) + sqr(ha.y));
        normal = {ha.x * -2.0f * sag.slope, ha.y * -2.0f * sag.slope, Float(1.0f)};
        if (i == steps) {
          ray.alive &= sag.valid & (abs(at.z - sag.z) < 1e-3f);
          p = at;
          break;
        }
        const Float along = dot(normal, d);
        t = t - (at.z - sag.z) / select(abs(along) > 1e-6f, along, Float(1e-6f));
      }
      normal = normalize(normal);
    }
  }
  ray.origin = {p.x, p.y, p.z + surface.z};
  const Float h2 = sqr(p.x) + sqr(p.y);
  ray.alive &= h2 <= surface.aperture_squared;
  for (std::int32_t i = 0; i < surface.edges; ++i) {
    const float* const edge = lens.edges.data() + surface.first_edge + 2 * i;
    ray.alive &= p.x * edge[0] + p.y * edge[1] <= surface.apothem;
  }
  return normal;
}

/// Ratios of indices at the wavelengths of 16 rays: a place between two of the table's.
struct WavelengthPlace {
  Int first = Int(0);
  Float part = Float(0.0f);
};
WavelengthPlace place_of(const LensTable& lens, Float nm) {
  if (lens.wavelengths == 1) return {};
  const Float place =
      clamp((nm - lens.first_nm) * lens.wavelengths_per_nm, 0.0f, static_cast<float>(lens.wavelengths - 1));
  const Int first = min(to_int(place), lens.wavelengths - 2);
  return {first, place - to_float(first)};
}
Float ratio_at(const LensTable& lens, std::size_t surface, const WavelengthPlace& place) {
  const float* const ratios = lens.ratios.data() + surface * static_cast<std::size_t>(lens.wavelengths);
  if (lens.wavelengths == 1) return Float(ratios[0]);
  const Float low = gather(ratios, place.first, Mask::all()),
              high = gather(ratios + 1, place.first, Mask::all());
  return fma(place.part, high - low, low);
}

/// Snell's law; the normal is on the side that the ray goes to.
void refract(Vec3 normal, Float ratio, LensRay& ray) {
  const Float cosine = dot(normal, ray.direction);
  const Float squared = 1.0f - sqr(ratio) * (1.0f - sqr(cosine));
  ray.alive &= (squared > 0.0f) & (cosine > 0.0f);
  ray.direction = normalize(ray.direction * ratio + normal * (sqrt(max(squared, 0.0f)) - ratio * cosine));
}

LocalRay ray_through(const LensTable& lens, Vec2 place, Vec2 u_lens, Float nm) {
  const Vec2 film = film_point(lens, place);
  const PupilSample pupil = sample_pupil(lens, film, u_lens);
  const Vec3 way{pupil.point.x - film.x, pupil.point.y - film.y, Float(lens.pupil_z)};
  LensRay ray{{film.x, film.y, Float(0.0f)}, normalize(way), pupil.area > 0.0f};
  const Float cosine = ray.direction.z;
  const WavelengthPlace wavelength = place_of(lens, nm);
  for (std::size_t i = 0; i < lens.surfaces.size() && any(ray.alive); ++i) {
    const Vec3 normal = meet(lens, lens.surfaces[i], ray);
    if (lens.surfaces[i].refracts != 0) refract(normal, ratio_at(lens, i, wavelength), ray);
  }
  const Vec3 forward{Float(0.0f), Float(0.0f), Float(1.0f)};
  LocalRay out;
  out.valid = ray.alive;
  out.origin = select(ray.alive, ray.origin * Float(lens.units_per_mm), forward * Float(0.0f));
  out.direction = select(ray.alive, ray.direction, forward);
  out.weight = pupil.area * (sqr(sqr(cosine)) * lens.weight);
  return out;
}

class LensSystemSensor final : public SensorModel {
 public:
  LensSystemSensor() : SensorModel({.has_lens = true, .connects = false, .may_fail = true, .weighs = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    return ray_through(*sensor.lens, place, u_lens, Float(0.0f));
  }
  LocalRay start_dispersed(const SensorRecord& sensor, Vec2 place, Vec2 u_lens,
                           Float wavelength) const override {
    return ray_through(*sensor.lens, place, u_lens, wavelength);
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<LensSystemSensor> lens_system(SensorKind::kLensSystem);

}  // namespace tessera::render::TESSERA_ISA

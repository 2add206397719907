#include "optics/lens_system.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "optics/reflectance.h"

namespace tessera::optics {

namespace {

using std::numbers::pi;

/// The conic and polynomial of an element over the squared height, and its slope by that.
struct Sag {
  double z, slope;
};
std::optional<Sag> sag_of(const LensSystem::Element& element, double h2) {
  const double c = element.curvature, k = 1 + element.surface.conic;
  const double under = 1 - k * c * c * h2;
  if (!(under > 0)) return std::nullopt;
  const double root = std::sqrt(under);
  Sag sag{c * h2 / (1 + root), c / (2 * root)};
  double power = h2;
  int order = 2;
  for (const double a : element.surface.aspheric) {
    // Prescriptions count heights towards the film.
    sag.slope -= a * order * power;
    sag.z -= a * (power *= h2);
    ++order;
  }
  return sag;
}

/// The direction across which a cylinder is curved, or nothing for bodies of revolution.
struct Across {
  bool all = true;
  double x = 0, y = 0;
};
Across across_of(const Surface& surface) {
  if (!surface.cylindrical) return {};
  const double angle = surface.axis_degrees * pi / 180 + pi / 2;
  return {false, std::cos(angle), std::sin(angle)};
}

}  // namespace

bool LensSystem::passes(const Element& element, Vector at) const {
  const double h2 = at.x * at.x + at.y * at.y, radius = element.surface.diameter / 2;
  if (!(h2 <= radius * radius)) return false;
  if (!element.surface.stop || use_.blades == 0) return true;
  const double sector = 2 * pi / use_.blades;
  const double turn = std::atan2(at.y, at.x) - use_.blade_degrees * pi / 180;
  const double from_edge = turn - (std::floor(turn / sector) + 0.5) * sector;
  return std::sqrt(h2) * std::cos(from_edge) <= radius * std::cos(sector / 2);
}

/// Moves the ray to the element, without a look at its aperture; returns a normal there, of any length.
std::optional<Vector> LensSystem::meet(const Element& element, Ray& ray) {
  if (ray.direction.z == 0) return std::nullopt;
  const Across across = across_of(element.surface);
  const auto project = [&](Vector v) {
    if (across.all) return v;
    const double u = v.x * across.x + v.y * across.y;
    return Vector{u * across.x, u * across.y, v.z};
  };
  Vector p = at_plane(ray, element.z);
  p.z = 0;  // heights are counted from the vertex
  const Vector d = ray.direction, d_across = project(d), p_across = project(p);
  const double c = element.curvature, k = 1 + element.surface.conic;
  // The root next to the vertex [Welford 1986, section 4.3].
  const double qa = c * (d_across.x * d_across.x + d_across.y * d_across.y + k * d.z * d.z),
               qb = d.z - c * (p_across.x * d_across.x + p_across.y * d_across.y),
               qc = c * (p_across.x * p_across.x + p_across.y * p_across.y);
  const double under = qb * qb - qa * qc;
  if (!(under >= 0)) return std::nullopt;
  double t = qc / (qb + std::copysign(std::sqrt(under), d.z));
  Vector normal{0, 0, 1};
  const bool aspheric = !element.surface.aspheric.empty();
  constexpr int kMostSteps = 40;
  for (int i = 0; i < (aspheric ? kMostSteps : 1); ++i) {
    const Vector at = project(p + d * t);
    const auto sag = sag_of(element, at.x * at.x + at.y * at.y);
    if (!sag) return std::nullopt;
    normal = {-2 * sag->slope * at.x, -2 * sag->slope * at.y, 1};
    if (!aspheric) break;
    const double off = p.z + d.z * t - sag->z, along = dot(normal, d);
    if (along == 0) return std::nullopt;
    t -= off / along;
    if (std::abs(off) < 1e-12) break;
    if (i + 1 == kMostSteps && !(std::abs(off) < 1e-9)) return std::nullopt;
  }
  ray.origin = p + d * t;
  ray.origin.z += element.z;
  return normal;
}

/// Moves the ray to the element and refracts it there.
bool LensSystem::step(const Element& element, double eta_before, double eta_behind, Ray& ray) const {
  const auto met = meet(element, ray);
  if (!met) return false;
  if (eta_before == eta_behind) return true;
  // Snell's law, the normal being on the side that the ray goes to.
  const Vector d = ray.direction;
  Vector normal = unit(*met);
  double cosine = dot(normal, d);
  if (cosine < 0) normal = normal * -1, cosine = -cosine;
  const double eta = eta_before / eta_behind, squared = 1 - eta * eta * (1 - cosine * cosine);
  if (!(squared > 0)) return false;
  ray.direction = unit(d * eta + normal * (std::sqrt(squared) - eta * cosine));
  return true;
}

/// Walks through the surfaces from one end.
struct LensSystem::Walk {
  const LensSystem& lens;
  double nm;
  bool stopped = true;

  double eta_before(std::size_t i) const {  // on the scene's side
    return i == 0 ? 1 : lens.elements_[i - 1].surface.behind.eta(nm);
  }
  double eta_behind(std::size_t i) const { return lens.elements_[i].surface.behind.eta(nm); }
  bool meets(std::size_t i, bool to_scene, Ray& ray) const {
    const Element& element = lens.elements_[i];
    if (!(to_scene ? ray.direction.z > 0 : ray.direction.z < 0)) return false;
    const double before = eta_before(i), behind = eta_behind(i);
    if (!lens.step(element, to_scene ? behind : before, to_scene ? before : behind, ray)) return false;
    return !stopped || lens.passes(element, ray.origin);
  }
  /// The same with what it loses, of a ray that is refracted or reflected.
  bool meets(std::size_t i, bool to_scene, bool reflects, DimmedRay& dimmed) const {
    const Element& element = lens.elements_[i];
    Ray& ray = dimmed.ray;
    if (!(to_scene ? ray.direction.z > 0 : ray.direction.z < 0)) return false;
    const double from = to_scene ? eta_behind(i) : eta_before(i),
                 to = to_scene ? eta_before(i) : eta_behind(i);
    Ray there = ray;
    const auto met = meet(element, there);
    if (!met || (stopped && !lens.passes(element, there.origin))) return false;
    const Vector normal = unit(*met);
    const double cosine = dot(normal, ray.direction);
    const double part = reflectance(from, to, element.surface.coating, cosine, nm);
    if (reflects) {
      there.direction = ray.direction - normal * (2 * cosine);
      ray = there;
    } else if (!lens.step(element, from, to, ray)) {
      return false;
    }
    dimmed.part *= reflects ? part : 1 - part;
    return true;
  }
};

std::optional<DimmedRay> LensSystem::follow(Ray ray, bool to_scene, const Bounce* bounce, double nm,
                                            bool stopped) const {
  const Walk walk{*this, nm, stopped};
  DimmedRay dimmed{ray};
  // Surfaces in the order in which the ray comes to them.
  const std::size_t n = elements_.size();
  const auto numbered = [&](std::size_t at) { return to_scene ? n - 1 - at : at; };
  std::size_t first = n, second = n;
  if (bounce != nullptr) {
    first = to_scene ? n - 1 - bounce->near_scene : bounce->near_film;
    second = to_scene ? n - 1 - bounce->near_film : bounce->near_scene;
  }
  for (std::size_t at = 0; at < n && at <= first; ++at)
    if (!walk.meets(numbered(at), to_scene, at == first, dimmed)) return std::nullopt;
  if (bounce == nullptr) return dimmed;
  for (std::size_t at = first; at-- > second;)
    if (!walk.meets(numbered(at), !to_scene, at == second, dimmed)) return std::nullopt;
  for (std::size_t at = second + 1; at < n; ++at)
    if (!walk.meets(numbered(at), to_scene, false, dimmed)) return std::nullopt;
  return dimmed;
}

std::optional<DimmedRay> LensSystem::refracted_to_film(Ray ray, double nm) const {
  return follow(ray, false, nullptr, nm, true);
}

std::optional<DimmedRay> LensSystem::refracted_to_scene(Ray ray, double nm) const {
  return follow(ray, true, nullptr, nm, true);
}

std::optional<DimmedRay> LensSystem::reflected_to_film(Ray ray, const Bounce& bounce, double nm,
                                                       bool stopped) const {
  return follow(ray, false, &bounce, nm, stopped);
}

std::optional<DimmedRay> LensSystem::reflected_to_scene(Ray ray, const Bounce& bounce, double nm) const {
  return follow(ray, true, &bounce, nm, true);
}

std::vector<Bounce> LensSystem::bounces(double nm) const {
  const Walk walk{*this, nm};
  std::vector<std::size_t> reflecting;
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    if (reflectance(walk.eta_before(i), walk.eta_behind(i), elements_[i].surface.coating, 1, nm) > 0)
      reflecting.push_back(i);
  }
  std::vector<Bounce> bounces;
  for (std::size_t k = 0; k < reflecting.size(); ++k)
    for (std::size_t i = 0; i < k; ++i) bounces.push_back({reflecting[i], reflecting[k]});
  return bounces;
}

std::optional<Ray> LensSystem::to_scene(Ray ray, double nm) const {
  const Walk walk{*this, nm};
  for (std::size_t i = elements_.size(); i-- > 0;)
    if (!walk.meets(i, true, ray)) return std::nullopt;
  return ray;
}

std::optional<Ray> LensSystem::unstopped(Ray ray, double nm) const {
  const Walk walk{*this, nm, false};
  for (std::size_t i = elements_.size(); i-- > 0;)
    if (!walk.meets(i, true, ray)) return std::nullopt;
  return ray;
}

std::optional<Ray> LensSystem::to_film(Ray ray, double nm) const {
  const Walk walk{*this, nm};
  for (std::size_t i = 0; i < elements_.size(); ++i)
    if (!walk.meets(i, false, ray)) return std::nullopt;
  return ray;
}

std::size_t LensSystem::end_of(Ray ray, double nm) const {
  const Walk walk{*this, nm};
  for (std::size_t i = elements_.size(); i-- > 0;)
    if (!walk.meets(i, true, ray)) return i;
  return elements_.size();
}

std::vector<Vector> LensSystem::path(Ray ray, double nm) const {
  std::vector<Vector> points{ray.origin};
  const Walk walk{*this, nm};
  for (std::size_t i = elements_.size(); i-- > 0;) {
    if (!walk.meets(i, true, ray)) return points;
    points.push_back(ray.origin);
  }
  points.push_back(ray.origin + ray.direction * (0.3 * front()));
  return points;
}

std::optional<Vector> LensSystem::at_stop(Ray ray, double nm) const {
  const Walk walk{*this, nm, false};
  for (std::size_t i = elements_.size(); i-- > stop_;)
    if (!walk.meets(i, true, ray)) return std::nullopt;
  return ray.origin;
}

void LensSystem::place(double back_distance) {
  double z = back_distance;
  for (std::size_t i = elements_.size(); i-- > 0;) {
    elements_[i].z = z;
    if (i > 0) z += elements_[i - 1].surface.thickness;
  }
}

}  // namespace tessera::optics

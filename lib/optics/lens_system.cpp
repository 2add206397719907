#include "optics/lens_system.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

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

void fault(std::vector<Fault>& faults, std::string message) { faults.push_back({0, 0, std::move(message)}); }

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

/// Moves the ray to the element and refracts it there, without a look at its aperture.
bool LensSystem::step(const Element& element, double eta_before, double eta_behind, Ray& ray) const {
  if (ray.direction.z == 0) return false;
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
  if (!(under >= 0)) return false;
  double t = qc / (qb + std::copysign(std::sqrt(under), d.z));
  Vector normal{0, 0, 1};
  const bool aspheric = !element.surface.aspheric.empty();
  constexpr int kMostSteps = 40;
  for (int i = 0; i < (aspheric ? kMostSteps : 1); ++i) {
    const Vector at = project(p + d * t);
    const auto sag = sag_of(element, at.x * at.x + at.y * at.y);
    if (!sag) return false;
    normal = {-2 * sag->slope * at.x, -2 * sag->slope * at.y, 1};
    if (!aspheric) break;
    const double off = p.z + d.z * t - sag->z, along = dot(normal, d);
    if (along == 0) return false;
    t -= off / along;
    if (std::abs(off) < 1e-12) break;
    if (i + 1 == kMostSteps && !(std::abs(off) < 1e-9)) return false;
  }
  ray.origin = p + d * t;
  ray.origin.z += element.z;
  if (eta_before == eta_behind) return true;
  // Snell's law, the normal being on the side that the ray goes to.
  normal = unit(normal);
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
};

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

bool LensSystem::set_stop(std::vector<Fault>& faults) {
  Surface& stop = elements_[stop_].surface;
  const double most = stop.diameter, pupil = std::abs(paraxial_.entrance_magnification);
  const double own_number = paraxial_.focal_length() / (most * pupil);
  double wanted = use_.stop_diameter > 0 ? use_.stop_diameter : most;
  if (use_.f_number > 0) wanted = paraxial_.focal_length() / (use_.f_number * pupil);
  // Names of lenses have rounded f-numbers: f/1.4 may be f/1.43.
  constexpr double kRounding = 1.03;
  if (!(wanted <= most * kRounding)) {
    fault(faults, use_.f_number > 0
                      ? absl::StrCat("f/", use_.f_number, " would need a stop of ", wanted,
                                     " mm, larger than its element, which has ", most, " mm: f/", own_number,
                                     " is the lens's own")
                      : absl::StrCat("an aperture of ", wanted,
                                     " mm is larger than its element: the stop has ", most, " mm"));
    return false;
  }
  if (!(wanted >= kLeastDiameter)) {
    fault(faults, use_.f_number > 0
                      ? absl::StrCat("f/", use_.f_number, " would need a stop of ", wanted, " mm; ",
                                     kLeastDiameter, " mm is the least")
                      : absl::StrCat("a stop of ", wanted, " mm; ", kLeastDiameter, " mm is the least"));
    return false;
  }
  stop.diameter = std::min(wanted, most);
  use_.stop_diameter = stop.diameter;
  use_.f_number = paraxial_.focal_length() / (stop.diameter * pupil);
  return true;
}

bool LensSystem::set_focus(std::vector<Fault>& faults) {
  const Paraxial& lens = paraxial_;
  double back = lens.back_focus();
  if (std::isfinite(use_.focus)) {
    // The distance of the film behind the lens at which the thing, film and lens add up: a quadratic
    // equation.
    const double between = use_.focus - lens.length, p = -lens.c, e = lens.d - lens.a;
    const double q = lens.c * between + e, r = lens.a * between + lens.b, under = q * q - 4 * p * r;
    const double half = 2 * lens.c * e - 4 * p * lens.a, rest = e * e - 4 * p * lens.b;
    const double nearest =
        (-half + std::sqrt(std::max(half * half - 4 * lens.c * lens.c * rest, 0.0))) / (2 * lens.c * lens.c) +
        lens.length;
    back = 2 * r / (-q + std::sqrt(std::max(under, 0.0)));
    if (!(under >= 0) || !(-q > 0) || !(use_.focus > 0) || !(use_.focus - lens.length - back > 0)) {
      fault(faults, absl::StrCat("a focus ", use_.focus, " mm from the film is nearer than possible; ",
                                 std::ceil(nearest), " mm is the least"));
      return false;
    }
  }
  if (!(back > 0)) {
    fault(faults,
          absl::StrCat("what is sharp would be ", -back, " mm within the lens, before its last surface"));
    return false;
  }
  place(back);
  return true;
}

/// Moves the film to where rays along the axis, all of the aperture, meet best (least squares).
bool LensSystem::refine_focus(std::vector<Fault>& faults) {
  constexpr int kRounds = 4, kRays = 32;
  for (int round = 0; round < kRounds; ++round) {
    const double front = elements_.front().z, pupil_z = front - paraxial_.entrance_pupil;
    const double pupil = std::abs(paraxial_.entrance_magnification) * elements_[stop_].surface.diameter / 2;
    double sum = 0, squares = 0;
    for (int i = 0; i < 2 * kRays; ++i) {
      const int ray_of_axis = i / 2;
      const double height = pupil * std::sqrt((ray_of_axis + 0.5) / kRays);
      const Vector in{i % 2 == 0 ? height : 0, i % 2 == 0 ? 0 : height, pupil_z};
      Ray ray{in, {0, 0, -1}};
      if (std::isfinite(use_.focus)) ray = {{0, 0, use_.focus}, unit(in - Vector{0, 0, use_.focus})};
      if (pupil_z >= use_.focus) continue;
      const auto out = to_film(ray, kLineD);
      if (!out) continue;
      const Vector at = at_plane(*out, 0);
      const double dx = out->direction.x / out->direction.z, dy = out->direction.y / out->direction.z;
      sum += at.x * dx + at.y * dy, squares += dx * dx + dy * dy;
    }
    if (!(squares > 0)) break;  // check_light() says why
    const double back = elements_.back().z + sum / squares;
    if (!(back > 0)) {
      fault(faults, "the rays along the axis meet within the lens");
      return false;
    }
    place(back);
  }
  return true;
}

/// Whether any light reaches the middle of the film.
bool LensSystem::check_light(std::vector<Fault>& faults) const {
  std::vector<int> ended(elements_.size());
  const Element& last = elements_.back();
  // A small stop lets nothing but rays close to the axis through.
  if (end_of({{0, 0, 0}, {0, 0, 1}}, kLineD) == elements_.size()) return true;
  constexpr int kRings = 64, kTurns = 16;
  for (int i = 0; i < kRings * kTurns; ++i) {
    const int ring = i / kTurns;
    const double r = last.surface.diameter / 2 * (ring + 0.5) / kRings, turn = 2 * pi * (i % kTurns) / kTurns;
    const std::size_t end =
        end_of({{0, 0, 0}, unit({r * std::cos(turn), r * std::sin(turn), last.z})}, kLineD);
    if (end == elements_.size()) return true;
    ++ended[end];
  }
  const auto most = static_cast<std::size_t>(std::max_element(ended.begin(), ended.end()) - ended.begin());
  faults.push_back(
      {elements_[most].surface.line, 0,
       absl::StrCat("no ray from the middle of the film gets through; most end at surface ", most + 1)});
  return false;
}

std::optional<LensSystem> LensSystem::focus(const Prescription& lens, const LensUse& use,
                                            std::vector<Fault>& faults) {
  const std::size_t before = faults.size();
  const std::vector<Fault> own = faults_of(lens);
  faults.insert(faults.end(), own.begin(), own.end());
  const auto is_size = [](double x) { return x >= 0 && std::isfinite(x); };
  if (!(use.focus > 0)) fault(faults, absl::StrCat("a focus at a distance of ", use.focus, " mm"));
  if (!is_size(use.f_number)) fault(faults, absl::StrCat("f/", use.f_number, " is no f-number"));
  if (!is_size(use.stop_diameter))
    fault(faults, absl::StrCat("a stop of ", use.stop_diameter, " mm is none"));
  if (use.f_number > 0 && use.stop_diameter > 0)
    fault(faults, "an f-number and a diameter of the stop exclude each other");
  if (use.blades != 0 && (use.blades < 3 || use.blades > 64))
    fault(faults, absl::StrCat("a stop has 3 to 64 blades, not ", use.blades));
  if (!std::isfinite(use.blade_degrees)) fault(faults, "the blades' angle is not finite");
  if (faults.size() > before) return std::nullopt;

  LensSystem system;
  system.lens_ = lens, system.use_ = use;
  constexpr double kAsGoodAsInfinite = 1e12;  // differences of such distances lose their digits
  if (use.focus > kAsGoodAsInfinite) system.use_.focus = HUGE_VAL;
  for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
    const Surface& surface = lens.surfaces[i];
    system.elements_.push_back({surface, 0, surface.radius != 0 ? -1 / surface.radius : 0});
    if (surface.stop) system.stop_ = i;
    if (surface.cylindrical) system.round_ = false;
    if (surface.behind.dispersion) system.disperses_ = true;
  }
  if (use.blades != 0) system.round_ = false;
  system.paraxial_ = paraxial_of(lens, kLineD);
  if (!(system.paraxial_.c < 0) || !std::isfinite(system.paraxial_.focal_length())) {
    fault(faults, absl::StrCat("its focal length is ", system.paraxial_.focal_length(),
                               " mm: it casts no image on a film"));
    return std::nullopt;
  }
  if (system.set_stop(faults) && system.set_focus(faults) && system.refine_focus(faults) &&
      system.check_light(faults))
    return system;
  return std::nullopt;
}

}  // namespace tessera::optics

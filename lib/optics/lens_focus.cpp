// How a lens comes to be used: its stop is set, then its film.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "optics/lens_system.h"

namespace tessera::optics {

namespace {

using std::numbers::pi;

/// `use`: the member of LensUse that is to blame.
void fault(std::vector<Fault>& faults, const char* use, std::string message) {
  faults.push_back({.message = std::move(message), .use = use});
}

}  // namespace

bool LensSystem::set_stop(std::vector<Fault>& faults) {
  Surface& stop = elements_[stop_].surface;
  const double most = stop.diameter, pupil = std::abs(paraxial_.entrance_magnification);
  const double own_number = paraxial_.focal_length() / (most * pupil);
  double wanted = use_.stop_diameter > 0 ? use_.stop_diameter : most;
  if (use_.f_number > 0) wanted = paraxial_.focal_length() / (use_.f_number * pupil);
  const char* const asked = use_.f_number > 0 ? "f_number" : "stop_diameter";
  // Names of lenses have rounded f-numbers: f/1.4 may be f/1.43.
  constexpr double kRounding = 1.03;
  if (!(wanted <= most * kRounding)) {
    fault(faults, asked,
          use_.f_number > 0 ? absl::StrCat("f/", use_.f_number, " would need a stop of ", wanted,
                                           " mm, larger than its element, which has ", most, " mm: f/",
                                           own_number, " is the lens's own")
                            : absl::StrCat("an aperture of ", wanted,
                                           " mm is larger than its element: the stop has ", most, " mm"));
    return false;
  }
  if (!(wanted >= kLeastDiameter)) {
    fault(faults, asked,
          use_.f_number > 0
              ? absl::StrCat("f/", use_.f_number, " would need a stop of ", wanted, " mm; ", kLeastDiameter,
                             " mm is the least")
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
      fault(faults, "focus",
            absl::StrCat("a focus ", use_.focus, " mm from the film is nearer than possible; ",
                         std::ceil(nearest), " mm is the least"));
      return false;
    }
  }
  if (!(back > 0)) {
    fault(faults, "focus",
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
      fault(faults, "", "the rays along the axis meet within the lens");
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
       absl::StrCat("no ray from the middle of the film gets through; most end at surface ", most + 1),
       most + 1});
  return false;
}

std::optional<LensSystem> LensSystem::focus(const Prescription& lens, const LensUse& use,
                                            std::vector<Fault>& faults) {
  const std::size_t before = faults.size();
  const std::vector<Fault> own = faults_of(lens);
  faults.insert(faults.end(), own.begin(), own.end());
  const auto is_size = [](double x) { return x >= 0 && std::isfinite(x); };
  if (!(use.focus > 0)) fault(faults, "focus", absl::StrCat("a focus at a distance of ", use.focus, " mm"));
  if (!is_size(use.f_number)) fault(faults, "f_number", absl::StrCat("f/", use.f_number, " is no f-number"));
  if (!is_size(use.stop_diameter))
    fault(faults, "stop_diameter", absl::StrCat("a stop of ", use.stop_diameter, " mm is none"));
  if (use.f_number > 0 && use.stop_diameter > 0)
    fault(faults, "stop_diameter", "an f-number and a diameter of the stop exclude each other");
  if (use.blades != 0 && (use.blades < 3 || use.blades > 64))
    fault(faults, "blades", absl::StrCat("a stop has 3 to 64 blades, not ", use.blades));
  if (!std::isfinite(use.blade_degrees)) fault(faults, "blade_degrees", "the blades' angle is not finite");
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
    fault(faults, "",
          absl::StrCat("its focal length is ", system.paraxial_.focal_length(),
                       " mm: it casts no image on a film"));
    return std::nullopt;
  }
  if (system.set_stop(faults) && system.set_focus(faults) && system.refine_focus(faults) &&
      system.check_light(faults))
    return system;
  return std::nullopt;
}

}  // namespace tessera::optics

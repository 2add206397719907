#include "optics/ghosts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tessera::optics {

namespace {

struct SourceRay {
  Ray ray;
  double light;  // that it stands for
};

/// Rays from the point through the front surface: on rings of equal area, on one radius of lenses that are
/// bodies of revolution.
std::vector<SourceRay> rays_of(const LensSystem& lens, int rings) {
  const LensSystem::Element& front = lens.elements().front();
  const double radius = front.surface.diameter / 2;
  constexpr int kTurns = 12;
  const int turns = lens.is_round() ? 1 : kTurns;
  std::vector<SourceRay> rays;
  for (int i = 0; i < rings * turns; ++i) {
    const int ring = i / turns;
    const double height = radius * std::sqrt((ring + 0.5) / rings);
    const double turn = 2 * std::numbers::pi * ((i % turns) + 0.5 * (ring % 2)) / turns;
    const Vector at{height * std::cos(turn), height * std::sin(turn), front.z};
    if (!std::isfinite(lens.focus_distance())) {
      rays.push_back({{at + Vector{0, 0, radius}, {0, 0, -1}}, 1});
      continue;
    }
    const Vector point{0, 0, lens.focus_distance()}, way = at - point;
    const double distance = length(way);
    rays.push_back({{point, unit(way)}, std::pow(-way.z / distance, 3)});
  }
  return rays;
}

/// Where a ray next to the axis meets it.
double paraxial_focus(const LensSystem& lens, const Bounce& bounce, double nm) {
  constexpr double kHeight = 1e-4;
  const Vector at{kHeight, 0, lens.front()};
  Ray ray{at + Vector{0, 0, 1}, {0, 0, -1}};
  if (std::isfinite(lens.focus_distance())) {
    const Vector point{0, 0, lens.focus_distance()};
    ray = {point, unit(at - point)};
  }
  const auto out = lens.reflected_to_film(ray, bounce, nm, false);
  if (!out || out->ray.direction.x == 0) return HUGE_VAL;
  const double way = -out->ray.origin.x / out->ray.direction.x;
  return out->ray.origin.z + way * out->ray.direction.z;
}

/// A ray from the film to a point of the last surface, and the etendue that it stands for.
struct FilmRay {
  Ray ray;
  double etendue;
};

/// Rays from places of the film at different heights, weighed by the area of their rings.
std::vector<FilmRay> film_rays(const LensSystem& lens, double half_diagonal, int points) {
  const LensSystem::Element& last = lens.elements().back();
  const double radius = last.surface.diameter / 2;
  constexpr int kHeights = 4;
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<FilmRay> rays;
  for (int k = 0; k < kHeights; ++k) {
    const Vector film{half_diagonal * std::sqrt((k + 0.5) / kHeights), 0, 0};
    for (int i = 0; i < points; ++i) {
      const double r = radius * std::sqrt((i + 0.5) / points), turn = kGoldenAngle * i;
      // Surfaces stand in for their planes, which is good enough.
      const Vector at{r * std::cos(turn), r * std::sin(turn), last.z - sag(last.surface, r).value_or(0)};
      const Vector way = at - film;
      rays.push_back({{film, unit(way)}, std::pow(way.z / length(way), 2) / dot(way, way)});
    }
  }
  return rays;
}

}  // namespace

std::vector<double> ghost_shares(const LensSystem& lens, const std::vector<Bounce>& bounces,
                                 double half_diagonal, double nm) {
  constexpr std::size_t kMostSteps = 3'000'000, kLeastPoints = 4, kMostPoints = 400;
  const std::size_t steps_a_point = 12 * lens.elements().size() * std::max<std::size_t>(bounces.size(), 1);
  const auto points = std::clamp(kMostSteps / steps_a_point, kLeastPoints, kMostPoints);
  const std::vector<FilmRay> rays = film_rays(lens, half_diagonal, static_cast<int>(points));
  double straight = 0;
  for (const FilmRay& from : rays) {
    if (const auto out = lens.refracted_to_scene(from.ray, nm)) straight += from.etendue * out->part;
  }
  std::vector<double> shares;
  for (const Bounce& bounce : bounces) {
    double share = 0;
    for (const FilmRay& from : rays) {
      if (const auto out = lens.reflected_to_scene(from.ray, bounce, nm)) share += from.etendue * out->part;
    }
    shares.push_back(straight > 0 ? share / straight : 0);
  }
  return shares;
}

std::vector<Ghost> ghosts_of(const LensSystem& lens, double nm) {
  const std::vector<Bounce> bounces = lens.bounces(nm);
  constexpr std::size_t kMostRays = 400'000, kMostRings = 400, kLeastRings = 20;
  const std::size_t all = std::max<std::size_t>(bounces.size(), 1);
  const auto rings = static_cast<int>(std::clamp(kMostRays / all, kLeastRings, kMostRings));
  const std::vector<SourceRay> rays = rays_of(lens, rings);
  double sharp = 0;
  for (const SourceRay& from : rays) {
    if (const auto out = lens.refracted_to_film(from.ray, nm)) sharp += from.light * out->part;
  }
  std::vector<Ghost> ghosts;
  for (const Bounce& bounce : bounces) {
    Ghost ghost{.bounce = bounce};
    for (const SourceRay& from : rays) {
      const auto out = lens.reflected_to_film(from.ray, bounce, nm);
      if (!out) continue;
      const Vector at = at_plane(out->ray, 0);
      ghost.part += from.light * out->part;
      ghost.diameter = std::max(ghost.diameter, 2 * std::hypot(at.x, at.y));
    }
    if (!(ghost.part > 0)) continue;
    ghost.part /= sharp;
    ghost.focus = paraxial_focus(lens, bounce, nm);
    ghosts.push_back(ghost);
  }
  const auto brightness = [](const Ghost& ghost) { return ghost.part / (ghost.diameter * ghost.diameter); };
  std::ranges::stable_sort(ghosts,
                           [&](const Ghost& a, const Ghost& b) { return brightness(a) > brightness(b); });
  return ghosts;
}

}  // namespace tessera::optics

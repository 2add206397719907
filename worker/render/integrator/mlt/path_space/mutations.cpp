#include "render/integrator/mlt/path_space/mutations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/camera/camera.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Steps on the film, in pixels; the largest reaches over this part of it [Veach 1997, section 11.4.3].
constexpr float kLeastFilmStep = 0.1f;
constexpr float kReach = 0.05f;

/// A path whose ends are those of `from`, with `events` events.
void keep_ends(const ExplicitPath& from, const KeptEnds& kept, int events, ExplicitPath& path) {
  path.events = events;
  path.time = from.time;
  path.lens_x = from.lens_x, path.lens_y = from.lens_y;
  std::copy_n(from.points + 1, kept.eye, path.points + 1);
  std::copy_n(from.points + from.events + 2 - kept.light, kept.light, path.points + events + 2 - kept.light);
}

/// The vertex up to which a path is followed from the eye: the first that neither it nor the next is on a
/// mirror, or the end. 0 where the strategy does not apply.
int followed_from_eye(const ExplicitPath& path, bool chains) {
  int vertex = 1, between = 0;
  for (;;) {
    while (vertex <= path.events && path.is_specular(vertex)) ++vertex;
    const bool at_end = vertex > path.events;
    if (at_end || vertex == path.events || !path.is_specular(vertex + 1)) {
      // Lights at a point cannot be met.
      if (at_end && !(path.from_eye[vertex] > 0)) return 0;
      return chains == (between > 0) ? vertex : 0;
    }
    ++between;
    ++vertex;
  }
}

/// The vertex that light leaves for the last but mirrors before the eye; 0 where there is none.
int followed_from_light(const ExplicitPath& path) {
  if (path.is_specular(1)) return 0;
  int vertex = 2;
  while (vertex <= path.events && path.is_specular(vertex)) ++vertex;
  return vertex;
}

}  // namespace

Mutations::Mutations(const SceneTables& scene)
    : film_(scene), max_events_(std::min(scene.max_depth, kMostEvents)), lengths_(max_events_) {}

std::vector<Strategy> Mutations::strategies_of(MutationKind kind) {
  switch (kind) {
    case MutationKind::kBidirectional:
      return {Strategy::kBidirectional};
    case MutationKind::kLens:
      return {Strategy::kLens};
    case MutationKind::kCaustic:
      return {Strategy::kCaustic};
    case MutationKind::kMultiChain:
      return {Strategy::kMultiChain};
    default:
      return {Strategy::kBidirectional, Strategy::kLens, Strategy::kCaustic, Strategy::kMultiChain};
  }
}

Growth Mutations::propose(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
                          ExplicitPath& path) const {
  switch (strategy) {
    case Strategy::kAllNew:
    case Strategy::kBidirectional:
      return renew(strategy, from, u, path);
    case Strategy::kCaustic:
      return perturb_from_light(from, path);
    case Strategy::kLens:
    case Strategy::kMultiChain:
      break;
  }
  return perturb_from_eye(strategy, from, u, path);
}

void Mutations::place_on_film(const ProposalNumbers& u, Growth& growth) const {
  growth.film_x = film_.left + film_.width * u.film_x;
  growth.film_y = film_.top + film_.height * u.film_y;
  growth.path->lens_x = u.lens_x, growth.path->lens_y = u.lens_y;
}

Growth Mutations::renew(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
                        ExplicitPath& path) const {
  Growth growth{.path = &path};
  if (strategy == Strategy::kBidirectional)
    growth.kept = lengths_.choose_kept(from.events, static_cast<double>(u.kept));
  const int added =
      lengths_.choose_added(growth.kept, growth.kept.removed(from.events), static_cast<double>(u.added));
  growth.alive = added >= 0;
  if (!growth.alive) return growth;
  keep_ends(from, growth.kept, growth.kept.vertices() + added - 1, path);
  const int ways = ways_to_add(growth.kept, added);
  growth.from_light = std::min(static_cast<int>(u.way * static_cast<float>(ways)), ways - 1);
  growth.from_eye = added - growth.from_light;
  if (growth.kept.eye == 0) place_on_film(u, growth);
  return growth;
}

Growth Mutations::perturb_from_eye(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
                                   ExplicitPath& path) const {
  Growth growth{.path = &path, .followed = &from};
  growth.from_eye = followed_from_eye(from, strategy == Strategy::kMultiChain);
  growth.kept.light = from.events + 1 - growth.from_eye;
  const float largest = std::sqrt(kReach * film_.area() / std::numbers::pi_v<float>);
  const float step = std::max(largest, 2 * kLeastFilmStep) *
                     std::pow(kLeastFilmStep / std::max(largest, 2 * kLeastFilmStep), u.film_x);
  const float angle = 2 * std::numbers::pi_v<float> * u.film_y;
  growth.film_x = from.film_x + step * std::cos(angle);
  growth.film_y = from.film_y + step * std::sin(angle);
  growth.alive = growth.from_eye > 0 && film_.contains(growth.film_x, growth.film_y);
  if (growth.alive) keep_ends(from, growth.kept, from.events, path);
  return growth;
}

Growth Mutations::perturb_from_light(const ExplicitPath& from, ExplicitPath& path) const {
  Growth growth{.path = &path, .followed = &from};
  const int vertex = followed_from_light(from);
  growth.from_light = vertex - 1;
  growth.kept.light = from.events + 2 - vertex;
  growth.alive = vertex > 0;
  if (growth.alive) keep_ends(from, growth.kept, from.events, path);
  return growth;
}

double Mutations::density(Strategy strategy, const ExplicitPath& from, const ExplicitPath& to,
                          const KeptEnds& kept) const {
  switch (strategy) {
    case Strategy::kLens:
    case Strategy::kMultiChain:
      return density_from_eye(to, to.events + 1 - kept.light);
    case Strategy::kCaustic:
      return density_from_light(to, to.events + 1 - kept.light);
    case Strategy::kAllNew:
    case Strategy::kBidirectional:
      break;
  }
  const int removed = kept.removed(from.events), added = kept.removed(to.events);
  const double ends = strategy == Strategy::kBidirectional ? lengths_.kept_probability(from.events, kept) : 1;
  return ends * lengths_.added_probability(kept, removed, added) * density_of_ways(to, kept) /
         ways_to_add(kept, added);
}

double Mutations::acceptance(Strategy strategy, const ExplicitPath& from, const ExplicitPath& to,
                             const KeptEnds& kept) const {
  if (!(to.brightness > 0)) return 0;
  const double there = density(strategy, from, to, kept), back = density(strategy, to, from, kept);
  const double ratio = to.brightness / from.brightness * (back / there);
  // What is next to impossible to find, or to leave, may overflow: from both of its sides.
  return std::isfinite(ratio) && there > 0 && back > 0 ? std::min(ratio, 1.0) : 0;
}

}  // namespace tessera::render::TESSERA_ISA

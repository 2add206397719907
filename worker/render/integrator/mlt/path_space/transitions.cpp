#include "render/integrator/mlt/path_space/transitions.h"

#include <cmath>
#include <cstdlib>

namespace tessera::render::TESSERA_ISA {

namespace {

/// By how many edges are removed [Veach 1997, section 11.4.2.1].
double weight_of_removed_edges(int edges) {
  return edges == 1 ? 0.25 : edges == 2 ? 0.5 : std::ldexp(1, -edges);
}

/// Pairs of ends, from the eye and from the light, that keep so many vertices of a path.
int ends_that_keep(int events, int vertices) { return std::min(events, vertices) + 1; }

double sum_of_kept(int events) {
  double sum = 0;
  for (int edges = 1; edges <= events + 2; ++edges)
    sum += weight_of_removed_edges(edges) * ends_that_keep(events, events + 2 - edges);
  return sum;
}

}  // namespace

KeptEnds LengthChoice::choose_kept(int events, double u) const {
  u *= sum_of_kept(events);
  for (int edges = 1;; ++edges) {
    const int vertices = events + 2 - edges, ends = ends_that_keep(events, vertices);
    const double each = weight_of_removed_edges(edges);
    if (u < each * ends || vertices == 0) {
      const int eye = std::min(static_cast<int>(u / each), ends - 1);
      return {eye, vertices - eye};
    }
    u -= each * ends;
  }
}

double LengthChoice::kept_probability(int events, const KeptEnds& kept) const {
  return weight_of_removed_edges(events + 2 - kept.vertices()) / sum_of_kept(events);
}

double LengthChoice::weight_of_added(const KeptEnds& kept, int removed, int added) const {
  // Not the same edge again, and not without an event or an end.
  if (removed == 0 && added == 0) return 0;
  if (kept.vertices() + added < 2 || (kept.light == 0 && added == 0)) return 0;
  switch (const int more = std::abs(added - removed); more) {
    case 0:
      return 0.5;
    case 1:
      return 0.15;
    default:
      return 0.2 * std::ldexp(1, -more);
  }
}

double LengthChoice::sum_of_added(const KeptEnds& kept, int removed) const {
  double sum = 0;
  for (int added = 0; added <= most_added(kept); ++added) sum += weight_of_added(kept, removed, added);
  return sum;
}

int LengthChoice::choose_added(const KeptEnds& kept, int removed, double u) const {
  u *= sum_of_added(kept, removed);
  int choice = -1;
  for (int added = 0; added <= most_added(kept); ++added) {
    const double weight = weight_of_added(kept, removed, added);
    if (weight == 0) continue;
    choice = added;
    if (u < weight) break;
    u -= weight;
  }
  return choice;
}

double LengthChoice::added_probability(const KeptEnds& kept, int removed, int added) const {
  if (added > most_added(kept)) return 0;
  const double weight = weight_of_added(kept, removed, added);
  return weight == 0 ? 0 : weight / sum_of_added(kept, removed);
}

double density_of_ways(const ExplicitPath& path, const KeptEnds& kept) {
  const int added = kept.removed(path.events), first = kept.eye + 1, end = path.events + 1;
  double from_light[kMostEvents + 3];  // of all added vertices from this one on
  from_light[added] = 1;
  for (int i = added - 1; i >= 0; --i) {
    const int vertex = first + i;
    double density = 0;
    if (kept.light > 1 || vertex < end - 1) {
      density = double{path.from_light[vertex]} * from_light[i + 1];
    } else if (kept.light == 0) {
      density = double{vertex == end ? path.sampled : path.emitted};
    }
    from_light[i] = density;
  }
  double sum = 0, from_eye = 1;
  for (int i = 0; i <= added; ++i) {
    // Both vertices of the edge that is put between them scatter light elsewhere, too.
    const int vertex = kept.eye + i;
    const bool joined = i < added || kept.light > 0;
    const bool possible = !joined || ((vertex == 0 || !path.is_specular(vertex)) &&
                                      (vertex + 1 == end || !path.is_specular(vertex + 1)));
    if (possible) sum += from_eye * from_light[i];
    if (i < added) from_eye *= double{path.from_eye[vertex + 1]};
  }
  return sum;
}

double density_until_light(const ExplicitPath& path) {
  double density = 1;
  for (int i = 1; i <= path.events + 1; ++i) {
    // Light that an emitter reflects is not found: the path ends there, unless it is the first vertex.
    if (i > 1 && i <= path.events && path.points[i].light >= 0) return 0;
    density *= double{path.from_eye[i]};
  }
  return density;
}

double density_from_eye(const ExplicitPath& path, int last) {
  double density = double{path.from_eye[1]};
  for (int i = 2; i <= last; ++i) density *= double{path.from_eye[i]} / double{path.eye_choice[i - 1]};
  return density;
}

double density_from_light(const ExplicitPath& path, int first) {
  double density = 1;
  for (int i = first; i >= 1; --i) {
    density *= i == path.events ? double{path.end_slope}
                                : double{path.from_light[i]} / double{path.light_choice[i + 1]};
  }
  return density;
}

}  // namespace tessera::render::TESSERA_ISA

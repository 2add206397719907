// How likely mutations lead from one path to another.
#pragma once

#include "render/integrator/mlt/path_space/explicit_path.h"

namespace tessera::render::TESSERA_ISA {

/// Ends that a path keeps: its first vertices, that on the lens not counted, and its last, the end on the
/// light counted. What is between them is removed.
struct KeptEnds {
  int eye = 0, light = 0;

  int vertices() const { return eye + light; }
  /// Vertices in place of which others come.
  int removed(int events) const { return events + 1 - vertices(); }
};

/// The discrete distributions of bidirectional mutations [Veach 1997, section 11.4.2].
class LengthChoice {
 public:
  explicit LengthChoice(int max_events) : most_(max_events) {}

  /// Which ends a path of so many events keeps; u is in [0, 1). Few vertices are removed mostly.
  KeptEnds choose_kept(int events, double u) const;
  /// Probability of that.
  double kept_probability(int events, const KeptEnds& kept) const;

  /// How many vertices are added in place of `removed` ones; -1 where there is no choice.
  int choose_added(const KeptEnds& kept, int removed, double u) const;
  double added_probability(const KeptEnds& kept, int removed, int added) const;

 private:
  double weight_of_added(const KeptEnds& kept, int removed, int added) const;
  double sum_of_added(const KeptEnds& kept, int removed) const;
  int most_added(const KeptEnds& kept) const { return most_ + 1 - kept.vertices(); }

  const int most_;
};

/// In how many ways vertices can be added: so many of them from the eye, the rest from the light. From an end
/// on a light that is kept no path begins.
inline int ways_to_add(const KeptEnds& kept, int added) { return kept.light == 1 ? 1 : added + 1; }

/// The sum over all these ways of the density with which they make what `path` has between its ends.
double density_of_ways(const ExplicitPath& path, const KeptEnds& kept);

/// The density of a path from the camera that goes on until it meets a light (Growth::until_light).
double density_until_light(const ExplicitPath& path);

/// The density with which a path is followed from the eye to vertex `last` through the same kinds of delta
/// lobes, directions elsewhere being as likely from here to there as back; which is left out.
double density_from_eye(const ExplicitPath& path, int last);
/// The same for vertices `first` to 1, followed from the one before `first`.
double density_from_light(const ExplicitPath& path, int first);

}  // namespace tessera::render::TESSERA_ISA

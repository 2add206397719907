// The strategies by which paths are changed, each with its acceptance probability [Veach 1997, section 11.4].
#pragma once

#include <vector>

#include "render/integrator/mlt/metropolis_config.h"
#include "render/integrator/mlt/path_space/grower.h"
#include "render/integrator/mlt/path_space/transitions.h"

namespace tessera::render::TESSERA_ISA {

enum class Strategy : std::uint8_t {
  kAllNew,         // a path that does not depend on the one before, but for its likely length
  kBidirectional,  // some vertices give way to others, from both sides
  kLens,           // the place on the film changes; up to a vertex that sees the rest of the path
  kCaustic,        // the direction changes that light leaves the second vertex but mirrors from the eye in
  kMultiChain      // like kLens, with directions at vertices between chains of mirrors
};

/// Numbers in [0, 1) that a proposal is made of, before it is traced.
struct ProposalNumbers {
  float kept, added, way;
  float film_x, film_y;
  float lens_x, lens_y;
};

class Mutations {
 public:
  explicit Mutations(const SceneTables& scene);

  /// The strategies of a kind, without kAllNew.
  static std::vector<Strategy> strategies_of(MutationKind kind);

  /// Proposes what `from` is to become, with all that is kept of it in `path`. Not alive where the strategy
  /// does not apply, or leads off the film.
  Growth propose(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
                 ExplicitPath& path) const;

  /// The probability with which a chain at `from` goes to `to`, which a proposal has kept that much of: that
  /// of Metropolis and Hastings, 0 where `to` carries no light.
  double acceptance(Strategy strategy, const ExplicitPath& from, const ExplicitPath& to,
                    const KeptEnds& kept) const;
  /// The tentative transition density from `from` to `to` when these ends are kept, but for factors that are
  /// the same from `to` to `from`.
  double density(Strategy strategy, const ExplicitPath& from, const ExplicitPath& to,
                 const KeptEnds& kept) const;

  /// Sets where on the film and on the lens a path begins whose first vertex is new.
  void place_on_film(const ProposalNumbers& u, Growth& growth) const;

  int max_events() const { return max_events_; }

 private:
  Growth renew(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
               ExplicitPath& path) const;
  Growth perturb_from_eye(Strategy strategy, const ExplicitPath& from, const ProposalNumbers& u,
                          ExplicitPath& path) const;
  Growth perturb_from_light(const ExplicitPath& from, ExplicitPath& path) const;

  const FilmPlane film_;
  const int max_events_;
  const LengthChoice lengths_;
};

}  // namespace tessera::render::TESSERA_ISA

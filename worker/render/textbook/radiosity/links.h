// Links: from whom a patch has its light, as coarsely as a bound on each link's error allows [Hanrahan,
// Salzman & Aupperle 1991].
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/textbook/radiosity/clusters.h"
#include "render/textbook/radiosity/form_factor.h"
#include "render/textbook/radiosity/matter.h"
#include "render/textbook/radiosity/visibility.h"
#include "wire/phases/radiosity_links.h"

namespace tessera::render::TESSERA_ISA::radiosity {

using Link = wire::RadiosityLink;

/// Irradiance by lights that are on no surface, W/m^2, all that are decided at this patch together.
struct DirectLight {
  Name receiver;
  Colour irradiance;
  std::uint32_t lights = 0;  // number of lights
};
static_assert(sizeof(DirectLight) == sizeof(wire::DirectLightBytes) &&
              offsetof(DirectLight, irradiance) == offsetof(wire::DirectLightBytes, irradiance));

/// Links by the receiver's side, ascending.
struct Links {
  std::vector<Link> links;
  std::vector<DirectLight> direct;
  std::uint64_t cut_short = 0;  // sides for whose links there was no room

  std::string blob() const;
  /// Appends those of a blob. False where it is none.
  bool append(std::string_view blob);
};

/// Whether they may be a Linker's: names of what is there, patches at level `deepest` at most, in the right
/// order; factors in [0, 1] and irradiances that are finite and not below 0.
bool are_sound(const Links& links, const Surfaces& surfaces, const Clusters& clusters, int deepest);

/// Light of sides and clusters, as far as it is known before it is linked: radiosities, W/m^2, the largest
/// band.
struct Brightness {
  struct Value {
    float whole = 0, emitted = 0;
  };
  std::vector<Value> sides, clusters;

  Value of(Name source) const {
    return source.is_cluster() ? clusters[source.cluster()] : sides[source.side()];
  }
};
/// Means of clusters from their sides.
void pull(const Surfaces& surfaces, const Clusters& clusters, Brightness& brightness);

struct LinkBounds {
  bool split = true;          // patches fall into parts; where not, sides are linked as they are
  double error = 0;           // largest error of a link, W/m^2
  double relative_error = 1;  // largest relative error of a link, where that is less
  double factor = 1;          // largest form factor of a cluster
  double smallest_area = 0;   // smaller patches are not split
  int rays = 5;               // traced from each of a receiver's points to a source
  // Most links of a side, and how many more over its area.
  double links_per_side = std::numeric_limits<double>::infinity();
  double links_per_area = 0;
};

/// Makes the links of sides, one after the other.
class Linker {
 public:
  Linker(const IntegratorContext& context, const Surfaces& surfaces, const Clusters& clusters,
         const Brightness& brightness, const LinkBounds& bounds);

  /// Appends all links of a side and its parts.
  void link(Side side, Links& to);

 private:
  /// A receiver and a source: a light where that is not negative.
  struct Pair {
    Name receiver, source;
    std::int32_t light = -1;
  };
  /// Findings about a pair, by rays from each of the receiver's points.
  struct Finding {
    View view;  // patches only
    // The light that arrives, and that would if nothing were in the way: for patches a count of rays, for
    // clusters parts of a form factor, for lights irradiance.
    Colour arrives[kPoints], sent[kPoints];

    /// Form factor at a point, with what is in the way; of patches.
    double factor(int point) const;
    /// Something is in the way of a part.
    bool partly_hidden() const;
  };
  /// One ray of a pair.
  struct Ray {
    std::size_t finding = 0;
    int point = 0;
    Colour carries;
  };
  enum class Decision { kDrop, kExamine, kLink, kSplitReceiver, kSplitSource };

  void examine(std::span<const Pair> pairs, std::vector<Finding>& findings);
  void aim_at_patch(const Pair& pair, const Patch& receiver, std::size_t index, Finding& finding);
  void aim_at_cluster(const Pair& pair, const Patch& receiver, std::size_t index);
  void aim_at_light(const Pair& pair, const Patch& receiver, std::size_t index);
  void trace(std::vector<Finding>& findings);
  bool can_split(Name patch) const;
  Decision before_rays(const Pair& pair) const;
  Decision after_rays(const Pair& pair, const Finding& finding) const;
  Decision patch_after_rays(const Pair& pair, const Finding& finding) const;
  Decision light_after_rays(const Pair& pair, const Finding& finding) const;
  void split(const Pair& pair, Decision decision, std::vector<Pair>& to) const;
  void append(const Pair& pair, const Finding& finding, Links& to);

  const IntegratorContext& context_;
  const Surfaces& surfaces_;
  const Clusters& clusters_;
  const Brightness& brightness_;
  const LinkBounds bounds_;
  std::vector<std::int32_t> lights_without_surface_;
  // Places in Links::direct of patches of the side at hand, by the bits of their names.
  std::unordered_map<std::uint64_t, std::size_t> lit_;
  Visibility visibility_;
  std::vector<Ray> visibility_rays_;
};

}  // namespace tessera::render::TESSERA_ISA::radiosity

// The solution: radiosities that agree with each other over all links.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/integrator/radiosity/links.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// Patches as the links have split them. Nodes 0 to sides() - 1 are the sides; the four parts of a node
/// follow one another.
class Forest {
 public:
  struct Node {
    Name name;
    std::uint32_t first_part = 0;  // 0: it is whole
    Colour irradiance;             // of whole ones: that of the patches that they are parts of, too; W/m^2
    Colour radiosity;              // W/m^2; of others the mean of their parts
    Matter matter;                 // of whole ones
  };

  /// Splits what the links name. Not there where they name what is not.
  static std::optional<Forest> grow(const SceneTables& scene, const Surfaces& surfaces,
                                    const Clusters& clusters, const Links& links);

  const std::vector<Node>& nodes() const { return nodes_; }
  const Node& node(std::size_t i) const { return nodes_[i]; }
  /// Bytes of `patches` nodes with `links`.
  static std::size_t bytes(std::size_t patches, std::size_t links) {
    return patches * sizeof(Node) + links * sizeof(NodeLink);
  }

  struct Outcome {
    int sweeps = 0;
    double residual = 0;  // power that the last sweep moved, over all that leaves the surfaces
  };
  /// Gauss-Seidel sweeps over the sides: each gathers the light over its links, pushes it down to its parts
  /// and pulls radiosity up from them [Hanrahan, Salzman & Aupperle 1991]; clusters follow after each sweep.
  /// The rest of an infinite series of sweeps moves at most residual r / (1 - r) of the power, with r the
  /// largest reflectance.
  Outcome solve(double residual);

  /// Radiosities of sides and clusters.
  Brightness brightness() const;
  /// Mean irradiance of the sides that there is light on, W/m^2, largest band.
  double mean_irradiance() const;

 private:
  struct NodeLink {
    std::uint32_t receiver, source;  // source: kCluster and a cluster, or a node
    float factor;
  };
  static constexpr std::uint32_t kCluster = std::uint32_t{1} << 31;

  Forest(const Surfaces& surfaces, const Clusters& clusters) : surfaces_(&surfaces), clusters_(&clusters) {}
  std::optional<std::uint32_t> find(Name name);
  bool add(const Links& links);
  void set_matter(const SceneTables& scene);
  Colour push_pull(std::uint32_t node, Colour from_above);
  double sweep(double& power);
  void pull_clusters();

  const Surfaces* surfaces_;
  const Clusters* clusters_;
  std::vector<Node> nodes_;
  std::vector<Colour> direct_, gathered_;  // irradiance of nodes, without that of patches they are parts of
  std::vector<Colour> cluster_radiosity_;
  std::vector<NodeLink> links_;          // by the receiver's side
  std::vector<std::size_t> side_begin_;  // of each side's links; one more at the end
};

}  // namespace tessera::render::TESSERA_ISA::radiosity

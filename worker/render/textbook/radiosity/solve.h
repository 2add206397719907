// The solution: radiosities that agree with each other over all links.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/textbook/radiosity/links.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// Patches as the links have split them. Nodes 0 to sides() - 1 are the sides; the four parts of a node
/// follow one another.
class Forest {
 public:
  struct Node {
    Name name;
    std::uint32_t first_part = 0;  // 0: it is whole
    Colour irradiance;             // whole ones: with that of the patches that they are parts of; W/m^2
    Colour radiosity;              // W/m^2; of others the mean of their parts
    Matter matter;                 // whole ones
    // Part of what the links bring that counts; whole ones only. Below 1 where it would reflect more than all
    // that can come to it.
    float share = 1;
  };

  /// Splits what the links name. Absent where these are not sound, name patches deeper than level `deepest`,
  /// or more of them than the scene's memory limit has room for.
  static std::optional<Forest> grow(const SceneTables& scene, const Surfaces& surfaces,
                                    const Clusters& clusters, const Links& links,
                                    int deepest = Name::kDeepest);

  const std::vector<Node>& nodes() const { return nodes_; }
  const Node& node(std::size_t i) const { return nodes_[i]; }
  struct Outcome {
    int sweeps = 0;
    double residual = 0;  // power that the last sweep moved, over all that leaves the surfaces
  };
  /// A Gauss-Seidel sweep more over the sides: each gathers the light over its links, pushes it down to its
  /// parts and pulls radiosity up from them [Hanrahan, Salzman & Aupperle 1991]; clusters follow. True once a
  /// sweep moves no more than `residual`, or no sweep more would help. The rest of an infinite series of
  /// sweeps moves at most residual r / (1 - r) of the power, with r the largest reflectance.
  bool advance(double residual);
  const Outcome& outcome() const { return outcome_; }

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
  void limit_shares();
  Colour push_pull(std::uint32_t node, Colour from_above, Colour over_links);
  double sweep(double& power);
  void pull_clusters();

  const Surfaces* surfaces_;
  const Clusters* clusters_;
  std::size_t most_nodes_ = 0;
  std::vector<Node> nodes_;
  std::vector<Colour> direct_, gathered_;  // irradiance of nodes, without that of patches they are parts of
  std::vector<Colour> cluster_radiosity_;
  std::vector<NodeLink> links_by_receiver_;
  std::vector<std::size_t> side_begin_;  // index of a side's first link; one more at the end
  Outcome outcome_;
};

}  // namespace tessera::render::TESSERA_ISA::radiosity

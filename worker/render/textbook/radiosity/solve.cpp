#include "render/textbook/radiosity/solve.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/textbook/radiosity/memory.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// Where light is lost nowhere the series has no end.
constexpr int kMostSweeps = 1000;

float largest(const Colour& light) { return *std::max_element(std::begin(light.band), std::end(light.band)); }

}  // namespace

std::optional<Forest> Forest::grow(const SceneTables& scene, const Surfaces& surfaces,
                                   const Clusters& clusters, const Links& links, int deepest) {
  if (!are_sound(links, surfaces, clusters, deepest)) return std::nullopt;
  static_assert(sizeof(Node) + 2 * sizeof(Colour) == render::radiosity::kBytesPerNode);
  Forest forest(surfaces, clusters);
  forest.most_nodes_ = static_cast<std::size_t>(
      std::min<std::uint64_t>(scene.radiosity.memory_limit / render::radiosity::kBytesPerNode, kCluster - 4));
  forest.nodes_.resize(surfaces.sides());
  for (Side side = 0; side < surfaces.sides(); ++side) forest.nodes_[side].name = Name::of_side(side);
  if (!forest.add(links)) return std::nullopt;
  forest.gathered_.resize(forest.nodes_.size());
  forest.set_matter(scene);
  forest.limit_shares();
  forest.pull_clusters();
  return forest;
}

/// The node with this name, split off where it is not there yet. Absent where there is no room.
std::optional<std::uint32_t> Forest::find(Name name) {
  std::uint32_t node = name.side();
  for (int level = 0; level < name.level(); ++level) {
    if (nodes_[node].first_part == 0) {
      const Name parent = nodes_[node].name;
      if (nodes_.size() + 4 > most_nodes_) return std::nullopt;
      nodes_[node].first_part = static_cast<std::uint32_t>(nodes_.size());
      for (unsigned i = 0; i < 4; ++i) {
        nodes_.emplace_back();
        nodes_.back().name = parent.part(i);
      }
    }
    node = nodes_[node].first_part + name.part_at(level);
  }
  return node;
}

bool Forest::add(const Links& links) {
  links_by_receiver_.reserve(links.links.size());
  side_begin_.assign(std::size_t{surfaces_->sides()} + 1, 0);
  Side last = 0;
  for (const Link& link : links.links) {
    const std::optional<std::uint32_t> receiver = find(link.receiver);
    const std::optional<std::uint32_t> source =
        link.source.is_cluster() ? kCluster | link.source.cluster() : find(link.source);
    if (!receiver || !source) return false;
    last = link.receiver.side();
    links_by_receiver_.push_back({*receiver, *source, static_cast<float>(link.factor)});
    side_begin_[last + 1] = links_by_receiver_.size();
  }
  for (std::size_t i = 1; i < side_begin_.size(); ++i)
    side_begin_[i] = std::max(side_begin_[i], side_begin_[i - 1]);
  std::vector<std::uint32_t> lit;
  for (const DirectLight& light : links.direct) {
    const std::optional<std::uint32_t> receiver = find(light.receiver);
    if (!receiver) return false;
    lit.push_back(*receiver);
  }
  direct_.resize(nodes_.size());
  for (std::size_t i = 0; i < lit.size(); ++i) direct_[lit[i]] += links.direct[i].irradiance;
  return true;
}

void Forest::set_matter(const SceneTables& scene) {
  std::vector<Name> names;
  std::vector<std::uint32_t> whole;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].first_part != 0 || !(surfaces_->area(nodes_[i].name.side()) > 0)) continue;
    names.push_back(nodes_[i].name);
    whole.push_back(i);
  }
  const std::vector<Matter> matter = matter_of(scene, *surfaces_, names);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    nodes_[whole[i]].matter = matter[i];
    nodes_[whole[i]].radiosity = matter[i].emission;
  }
  // Parts have larger numbers than what they are parts of.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.first_part == 0) continue;
    for (std::uint32_t part = 0; part < 4; ++part)
      node.radiosity += nodes_[node.first_part + part].radiosity * 0.25f;
  }
}

/// Factors are estimates, and nothing keeps their sum over a patch at or below 1. Where a patch would so
/// reflect more than all that can come to it, light could grow from sweep to sweep without end.
void Forest::limit_shares() {
  std::vector<float> sum(nodes_.size());
  for (const NodeLink& link : links_by_receiver_) sum[link.receiver] += link.factor;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    for (std::uint32_t part = 0; node.first_part != 0 && part < 4; ++part)
      sum[node.first_part + part] += sum[i];
    if (node.first_part == 0 && sum[i] * largest(node.matter.reflectance) > 1) node.share = 1 / sum[i];
  }
}

Colour Forest::push_pull(std::uint32_t index, Colour from_above, Colour over_links) {
  Node& node = nodes_[index];
  from_above += direct_[index] + gathered_[index];
  over_links += gathered_[index];
  gathered_[index] = {};
  if (node.share < 1) from_above += over_links * (node.share - 1);
  node.irradiance = from_above;
  if (node.first_part == 0)
    return node.radiosity = node.matter.emission + node.matter.reflectance * from_above;
  Colour sum, irradiance;
  for (std::uint32_t part = 0; part < 4; ++part) {
    sum += push_pull(node.first_part + part, from_above, over_links);
    irradiance += nodes_[node.first_part + part].irradiance;
  }
  node.irradiance = irradiance * 0.25f;
  return node.radiosity = sum * 0.25f;
}

double Forest::sweep(double& power) {
  double moved = 0;
  power = 0;
  for (Side side = 0; side < surfaces_->sides(); ++side) {
    for (std::size_t i = side_begin_[side]; i < side_begin_[side + 1]; ++i) {
      const NodeLink& link = links_by_receiver_[i];
      const Colour& source = (link.source & kCluster) != 0 ? cluster_radiosity_[link.source & ~kCluster]
                                                           : nodes_[link.source].radiosity;
      gathered_[link.receiver] += source * link.factor;
    }
    const float before = nodes_[side].radiosity.mean();
    const float after = push_pull(side, {}, {}).mean();
    moved += surfaces_->area(side) * std::abs(double{after} - double{before});
    power += surfaces_->area(side) * double{after};
  }
  pull_clusters();
  return moved;
}

void Forest::pull_clusters() {
  const std::vector<Cluster>& all = clusters_->all();
  cluster_radiosity_.resize(all.size());
  for (std::size_t i = all.size(); i-- > 0;) {
    if (all[i].count == 1) {
      cluster_radiosity_[i] = nodes_[clusters_->only_side(all[i])].radiosity;
      continue;
    }
    cluster_radiosity_[i] = {};
    for (const std::uint32_t child : all[i].children)
      cluster_radiosity_[i] += cluster_radiosity_[child] * static_cast<float>(all[child].area / all[i].area);
  }
}

bool Forest::advance(double residual) {
  const auto is_over = [&] {
    return outcome_.sweeps == kMostSweeps ||
           (outcome_.sweeps > 0 && (outcome_.residual <= residual || !std::isfinite(outcome_.residual)));
  };
  if (is_over()) return true;
  double power = 0;
  const double moved = sweep(power);
  ++outcome_.sweeps;
  outcome_.residual = power == 0 ? 0 : moved / power;
  return is_over();
}

Brightness Forest::brightness() const {
  Brightness result;
  for (Side side = 0; side < surfaces_->sides(); ++side)
    result.sides.push_back({largest(nodes_[side].radiosity), largest(nodes_[side].matter.emission)});
  pull(*surfaces_, *clusters_, result);
  return result;
}

double Forest::mean_irradiance() const {
  double area = 0, sum = 0;
  for (Side side = 0; side < surfaces_->sides(); ++side) {
    const double irradiance = double{largest(nodes_[side].irradiance)};
    if (!(irradiance > 0)) continue;
    area += surfaces_->area(side);
    sum += surfaces_->area(side) * irradiance;
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity

#include "render/integrator/radiosity/solve.h"

#include <algorithm>
#include <cmath>

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

/// Where light is lost nowhere the series has no end.
constexpr int kMostSweeps = 1000;

float largest(const Colour& light) { return *std::max_element(std::begin(light.band), std::end(light.band)); }

}  // namespace

std::optional<Forest> Forest::grow(const SceneTables& scene, const Surfaces& surfaces,
                                   const Clusters& clusters, const Links& links) {
  Forest forest(surfaces, clusters);
  forest.nodes_.resize(surfaces.sides());
  for (Side side = 0; side < surfaces.sides(); ++side) forest.nodes_[side].name = Name::of_side(side);
  if (!forest.add(links)) return std::nullopt;
  forest.gathered_.resize(forest.nodes_.size());
  forest.set_matter(scene);
  forest.pull_clusters();
  return forest;
}

/// The node with this name, split off where it is not there yet.
std::optional<std::uint32_t> Forest::find(Name name) {
  if (name.is_cluster() || name.side() >= surfaces_->sides() || name.level() > Name::kDeepest)
    return std::nullopt;
  std::uint32_t node = name.side();
  for (int level = 0; level < name.level(); ++level) {
    if (nodes_[node].first_part == 0) {
      const Name parent = nodes_[node].name;
      if (nodes_.size() >= kCluster - 4) return std::nullopt;
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
  links_.reserve(links.links.size());
  side_begin_.assign(std::size_t{surfaces_->sides()} + 1, 0);
  Side last = 0;
  for (const Link& link : links.links) {
    if (link.source.is_cluster() && link.source.cluster() >= clusters_->all().size()) return false;
    const std::optional<std::uint32_t> receiver = find(link.receiver);
    const std::optional<std::uint32_t> source =
        link.source.is_cluster() ? kCluster | link.source.cluster() : find(link.source);
    if (!receiver || !source || link.receiver.side() < last) return false;
    last = link.receiver.side();
    links_.push_back({*receiver, *source, static_cast<float>(link.factor)});
    side_begin_[last + 1] = links_.size();
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

Colour Forest::push_pull(std::uint32_t index, Colour from_above) {
  Node& node = nodes_[index];
  from_above += direct_[index] + gathered_[index];
  gathered_[index] = {};
  node.irradiance = from_above;
  if (node.first_part == 0)
    return node.radiosity = node.matter.emission + node.matter.reflectance * from_above;
  Colour sum, irradiance;
  for (std::uint32_t part = 0; part < 4; ++part) {
    sum += push_pull(node.first_part + part, from_above);
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
      const NodeLink& link = links_[i];
      const Colour& source = (link.source & kCluster) != 0 ? cluster_radiosity_[link.source & ~kCluster]
                                                           : nodes_[link.source].radiosity;
      gathered_[link.receiver] += source * link.factor;
    }
    const float before = nodes_[side].radiosity.mean();
    const float after = push_pull(side, {}).mean();
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

Forest::Outcome Forest::solve(double residual) {
  Outcome outcome;
  while (outcome.sweeps < kMostSweeps) {
    double power = 0;
    const double moved = sweep(power);
    ++outcome.sweeps;
    outcome.residual = power > 0 ? moved / power : 0;
    if (outcome.residual <= residual) break;
  }
  return outcome;
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

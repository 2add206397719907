#include <algorithm>
#include <cmath>

#include "render/integrator/radiosity/blob.h"
#include "render/integrator/radiosity/links.h"

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

using render::radiosity::append_values;
using render::radiosity::put_array;
using render::radiosity::put_count;
using render::radiosity::take_array;
using render::radiosity::take_bytes;

/// Arrays of a blob of links.
struct LinkBytes {
  std::string_view links, direct;
  std::uint64_t cut_short = 0;
};

std::optional<LinkBytes> read_bytes(std::string_view blob) {
  LinkBytes bytes;
  std::vector<std::uint64_t> cut;
  if (!take_bytes<Link>(blob, bytes.links) || !take_bytes<DirectLight>(blob, bytes.direct) ||
      !take_array(blob, cut) || cut.size() != 1 || !blob.empty())
    return std::nullopt;
  bytes.cut_short = cut.front();
  return bytes;
}

}  // namespace

std::string Links::blob() const {
  std::string blob;
  put_array(links, blob);
  put_array(direct, blob);
  put_array(std::vector{cut_short}, blob);
  return blob;
}

bool Links::append(std::string_view blob) {
  const std::optional<LinkBytes> bytes = read_bytes(blob);
  if (!bytes) return false;
  append_values(bytes->links, links);
  append_values(bytes->direct, direct);
  cut_short += bytes->cut_short;
  return true;
}

std::optional<std::string> Links::merge(std::span<const std::string_view> blobs) {
  std::vector<LinkBytes> all;
  std::size_t links = 0, direct = 0, whole = 0;
  std::uint64_t cut_short = 0;
  for (const std::string_view blob : blobs) {
    const std::optional<LinkBytes> bytes = read_bytes(blob);
    if (!bytes) return std::nullopt;
    all.push_back(*bytes);
    links += bytes->links.size(), direct += bytes->direct.size(), whole += blob.size();
    cut_short += bytes->cut_short;
  }
  std::string merged;
  merged.reserve(whole);
  put_count(links / sizeof(Link), merged);
  for (const LinkBytes& bytes : all) merged += bytes.links;
  put_count(direct / sizeof(DirectLight), merged);
  for (const LinkBytes& bytes : all) merged += bytes.direct;
  put_array(std::vector{cut_short}, merged);
  return merged;
}

bool are_sound(const Links& links, const Surfaces& surfaces, const Clusters& clusters, int deepest) {
  const auto is_patch = [&](Name name) {
    return !name.is_cluster() && name.side() < surfaces.sides() && name.level() <= deepest;
  };
  Side last = 0;
  for (const Link& link : links.links) {
    const bool there =
        link.source.is_cluster() ? link.source.cluster() < clusters.all().size() : is_patch(link.source);
    if (!there || !is_patch(link.receiver) || link.receiver.side() < last) return false;
    if (!(link.factor >= 0 && link.factor <= 1)) return false;
    last = link.receiver.side();
  }
  return std::all_of(links.direct.begin(), links.direct.end(), [&](const DirectLight& light) {
    return is_patch(light.receiver) &&
           std::all_of(std::begin(light.irradiance.band), std::end(light.irradiance.band),
                       [](float value) { return value >= 0 && std::isfinite(value); });
  });
}

}  // namespace tessera::render::TESSERA_ISA::radiosity

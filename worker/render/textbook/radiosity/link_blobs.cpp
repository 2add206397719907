#include <algorithm>

#include "render/textbook/radiosity/links.h"
#include "wire/phases/blob_arrays.h"

namespace tessera::render::TESSERA_ISA::radiosity {

std::string Links::blob() const {
  std::string blob;
  wire::put_array(links, blob);
  wire::put_array(direct, blob);
  wire::put_array(std::vector{cut_short}, blob);
  return blob;
}

bool Links::append(std::string_view blob) {
  const std::optional<wire::LinkBytes> bytes = wire::read_links(blob);
  if (!bytes) return false;
  wire::append_values(bytes->links, links);
  wire::append_values(bytes->direct, direct);
  cut_short += bytes->cut_short;
  return true;
}

bool are_sound(const Links& links, const Surfaces& surfaces, const Clusters& clusters, int deepest) {
  const auto is_there = [&](Name name) {
    return name.is_cluster() ? name.cluster() < clusters.all().size() : name.side() < surfaces.sides();
  };
  Side last = 0;
  for (const Link& link : links.links) {
    if (!wire::is_sound(link, deepest) || !is_there(link.source) || !is_there(link.receiver)) return false;
    if (link.receiver.side() < last) return false;
    last = link.receiver.side();
  }
  return std::ranges::all_of(links.direct, [&](const DirectLight& light) {
    return wire::is_sound(light.receiver, light.irradiance.band, deepest) && is_there(light.receiver);
  });
}

}  // namespace tessera::render::TESSERA_ISA::radiosity

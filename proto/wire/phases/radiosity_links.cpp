#include "wire/phases/radiosity_links.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "wire/phases/blob_arrays.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

namespace {

bool is_patch(PatchName name, int deepest) { return !name.is_cluster() && name.level() <= deepest; }

std::uint64_t most_link_bytes(const PhaseBlob& blob) { return blob.memory_limit; }

const char* link_fault(std::string_view bytes, int deepest) {
  return read_links(bytes, deepest) ? nullptr : "no links that radiosity makes";
}

}  // namespace

bool is_sound(const RadiosityLink& link, int deepest) {
  return is_patch(link.receiver, deepest) && link.factor >= 0 && link.factor <= 1 &&
         (link.source.is_cluster() || is_patch(link.source, deepest));
}

bool is_sound(PatchName receiver, const float (&irradiance)[3], int deepest) {
  return is_patch(receiver, deepest) &&
         std::all_of(std::begin(irradiance), std::end(irradiance),
                     [](float value) { return value >= 0 && std::isfinite(value); });
}

std::optional<LinkBytes> read_links(std::string_view blob, int deepest) {
  LinkBytes bytes;
  std::vector<std::uint64_t> cut;
  if (!take_bytes<RadiosityLink>(blob, bytes.links) || !take_bytes<DirectLightBytes>(blob, bytes.direct) ||
      !take_array(blob, cut) || cut.size() != 1 || !blob.empty())
    return std::nullopt;
  bytes.cut_short = cut.front();
  TriangleSide last = 0;
  const auto is_link = [&](const RadiosityLink& link) {
    const bool ascends = link.receiver.side() >= last;
    last = link.receiver.side();
    return ascends && is_sound(link, deepest);
  };
  const auto is_light = [&](const DirectLightBytes& light) {
    return is_sound(light.receiver, light.irradiance, deepest);
  };
  if (!all_in_bytes<RadiosityLink>(bytes.links, is_link) ||
      !all_in_bytes<DirectLightBytes>(bytes.direct, is_light))
    return std::nullopt;
  return bytes;
}

std::optional<std::string> merge_links(std::span<const std::string_view> blobs) {
  std::vector<LinkBytes> all;
  std::size_t links = 0, direct = 0, whole = 0;
  std::uint64_t cut_short = 0;
  for (const std::string_view blob : blobs) {
    const std::optional<LinkBytes> bytes = read_links(blob);
    if (!bytes) return std::nullopt;
    all.push_back(*bytes);
    links += bytes->links.size(), direct += bytes->direct.size(), whole += blob.size();
    cut_short += bytes->cut_short;
  }
  std::string merged;
  merged.reserve(whole);
  put_count(links / sizeof(RadiosityLink), merged);
  for (const LinkBytes& bytes : all) merged += bytes.links;
  put_count(direct / sizeof(DirectLightBytes), merged);
  for (const LinkBytes& bytes : all) merged += bytes.direct;
  put_array(std::vector{cut_short}, merged);
  return merged;
}

const PhaseBlobCheck kEstimateLinksCheck{
    most_link_bytes, [](std::string_view bytes, const PhaseBlob&) { return link_fault(bytes, 0); }};
const PhaseBlobCheck kPatchLinksCheck{most_link_bytes, [](std::string_view bytes, const PhaseBlob&) {
                                        return link_fault(bytes, PatchName::kDeepest);
                                      }};

}  // namespace tessera::wire

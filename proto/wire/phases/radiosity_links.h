// Blobs of links between patches: of the first two phases of radiosity.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "wire/phases/patch_name.h"

namespace tessera::wire {

/// The patch `receiver` and all of its parts have `factor` times the radiosity of `source` as irradiance.
struct RadiosityLink {
  PatchName receiver, source;
  double factor = 0;  // form factor, with what is in the way
};

/// Irradiance by lights that are on no surface, as blobs have it.
struct DirectLightBytes {
  PatchName receiver;
  float irradiance[3];
  std::uint32_t lights;
};
static_assert(sizeof(RadiosityLink) == 24 && sizeof(DirectLightBytes) == 24);

/// Whether it may be a linker's, of patches at level `deepest` at most: its receiver is a patch, its factor
/// in [0, 1].
bool is_sound(const RadiosityLink& link, int deepest);
/// The same of direct light: finite, and not below 0.
bool is_sound(PatchName receiver, const float (&irradiance)[3], int deepest);

/// Arrays of a blob of links.
struct LinkBytes {
  std::string_view links, direct;
  std::uint64_t cut_short = 0;  // sides for whose links there was no room
};

/// Absent where the blob has others than sound ones, or links that do not ascend by their receivers' sides.
std::optional<LinkBytes> read_links(std::string_view blob, int deepest = PatchName::kDeepest);
/// The blob of all that blobs hold, one after the other. Absent where one of them is none.
std::optional<std::string> merge_links(std::span<const std::string_view> blobs);

}  // namespace tessera::wire

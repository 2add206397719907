// Spots: parts of tiles that a second identity renders again. Bits do not depend on tiles
// [docs/architecture.md], so a spot of a right result has the bits that it has alone.
#pragma once

#include <cstdint>
#include <string>

#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

/// Side of a spot, pixels: pixels that share light, and those that are decided on together, are in cells of
/// this size on the film's grid.
inline constexpr std::uint32_t kSpotSide = 8;

/// How many spots there are in these pixels.
std::uint32_t spots_in(const v1::PixelRect& pixels);

/// The pixels of a spot, which are numbered from 1.
v1::PixelRect spot_pixels(const v1::PixelRect& pixels, std::uint32_t spot);

/// The spot by which the result of this lease may be checked; 0 where the pixels have no more than one. Who
/// does not have the key cannot tell it.
std::uint32_t choose_spot(const std::string& key, const v1::LeaseToken& token, const v1::PixelRect& pixels);

/// Part of a unit's work that a spot is, at most: `scatters` where tiles are rendered with a border.
double spot_share(const v1::PixelRect& pixels, bool scatters);

}  // namespace tessera::server

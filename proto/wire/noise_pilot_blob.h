// Findings of a pilot of a picture's noise, as workers give it to each other and coordinators show it
// [docs/decisions/0060-noise-phase.md].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "wire/phases/phase_blob.h"

namespace tessera::wire {

/// The measurements of a block. Two halves of its pixels are kept apart, so that one can judge what was made
/// of the other.
struct PilotBlock {
  std::array<float, 2> error{};  // relMSE that single samples would have, by each half of the block's pixels
  float cost = 0;                // rays a sample
};

/// Squared error that counts as none at all in the dark, as relMSE has it [Rousselle et al. 2011].
inline constexpr double kPilotDarkness = 0.01;
/// Largest error that a block may tell of, and cost: sums over a film of them are finite.
inline constexpr float kMostPilotError = 1e30f;

/// Blocks [x0, x1) x [y0, y1) of kNoiseBlock pixels each way, on the film's grid.
struct PilotBlocks {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  std::vector<PilotBlock> values;  // rows from the top

  std::size_t count() const { return std::size_t{x1 - x0} * (y1 - y0); }
  /// The block of a pixel of the film; null beyond them.
  const PilotBlock* at(std::uint32_t x, std::uint32_t y) const;
};

/// The blocks, without values, of parts [first_part, end_part) of a pilot of a crop's pixels: parts are
/// stripes of whole rows of blocks.
PilotBlocks pilot_stripe(const PhaseBlob& blob);

/// Returns the bytes; empty for one without blocks.
std::string pilot_blob(const PilotBlocks& pilot);
/// Puts `blob` under `pilot`, which may be empty. False where it is no blob of a pilot, or not of the blocks
/// that come next.
bool append_pilot_blob(std::string_view blob, PilotBlocks& pilot);

}  // namespace tessera::wire

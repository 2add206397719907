#include "wire/noise_pilot_blob.h"

#include <cstring>

#include "wire/film_size.h"
#include "wire/limits.h"

namespace tessera::wire {
namespace {

using Rect = std::array<std::uint32_t, 4>;  // x0, y0, x1, y1

std::uint64_t most_pilot_bytes(const PhaseBlob& blob) {
  return sizeof(Rect) + pilot_stripe(blob).count() * sizeof(PilotBlock);
}

const char* pilot_fault(std::string_view bytes, const PhaseBlob& blob) {
  PilotBlocks found;
  const PilotBlocks expected = pilot_stripe(blob);
  if (!append_pilot_blob(bytes, found)) return "no pilot of a picture's noise";
  const bool same = expected.count() == 0
                        ? found.values.empty()
                        : found.x0 == expected.x0 && found.y0 == expected.y0 && found.x1 == expected.x1 &&
                              found.y1 == expected.y1 && found.values.size() == expected.count();
  return same ? nullptr : "a pilot of other blocks of the picture than its own";
}

}  // namespace

const PilotBlock* PilotBlocks::at(std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t u = x / kNoiseBlock, v = y / kNoiseBlock;
  if (u < x0 || u >= x1 || v < y0 || v >= y1) return nullptr;
  return &values[std::size_t{v - y0} * (x1 - x0) + (u - x0)];
}

PilotBlocks pilot_stripe(const PhaseBlob& blob) {
  const auto up = [](std::uint32_t pixels) { return (pixels + kNoiseBlock - 1) / kNoiseBlock; };
  const std::uint32_t top = blob.crop.y0 / kNoiseBlock;
  const std::uint64_t rows = up(blob.crop.y1) - top;
  const auto row = [&](std::uint64_t part) {
    return top + static_cast<std::uint32_t>(rows * part / blob.parts);
  };
  return {.x0 = blob.crop.x0 / kNoiseBlock,
          .y0 = row(blob.first_part),
          .x1 = up(blob.crop.x1),
          .y1 = row(blob.end_part),
          .values = {}};
}

std::string pilot_blob(const PilotBlocks& pilot) {
  if (pilot.values.empty()) return "";
  static_assert(sizeof(Rect) == 16 && sizeof(PilotBlock) == 12);
  const Rect rect{pilot.x0, pilot.y0, pilot.x1, pilot.y1};
  std::string blob(sizeof(Rect) + pilot.values.size() * sizeof(PilotBlock), '\0');
  std::memcpy(blob.data(), rect.data(), sizeof(Rect));
  std::memcpy(blob.data() + sizeof(Rect), pilot.values.data(), blob.size() - sizeof(Rect));
  return blob;
}

bool append_pilot_blob(std::string_view blob, PilotBlocks& pilot) {
  constexpr std::uint32_t kMostBlocks = (kMaxFilmSide + kNoiseBlock - 1) / kNoiseBlock;
  if (blob.empty()) return true;
  Rect rect;
  if (blob.size() < sizeof(rect)) return false;
  std::memcpy(rect.data(), blob.data(), sizeof(rect));
  blob.remove_prefix(sizeof(rect));
  const PilotBlocks added{.x0 = rect[0], .y0 = rect[1], .x1 = rect[2], .y1 = rect[3], .values = {}};
  if (!(added.x0 < added.x1 && added.x1 <= kMostBlocks && added.y0 < added.y1 && added.y1 <= kMostBlocks &&
        blob.size() == added.count() * sizeof(PilotBlock)))
    return false;
  const std::size_t first = pilot.values.size();
  if (first > 0 && (added.x0 != pilot.x0 || added.x1 != pilot.x1 || added.y0 != pilot.y1)) return false;
  pilot.values.resize(first + added.count());
  std::memcpy(&pilot.values[first], blob.data(), blob.size());
  const auto is_in = [](float value, float least) { return value >= least && value <= kMostPilotError; };
  for (std::size_t i = first; i < pilot.values.size(); ++i) {
    const PilotBlock& block = pilot.values[i];
    if (!is_in(block.error[0], 0) || !is_in(block.error[1], 0) || !is_in(block.cost, 1)) return false;
  }
  if (first == 0) pilot.x0 = added.x0, pilot.x1 = added.x1, pilot.y0 = added.y0;
  pilot.y1 = added.y1;
  return true;
}

const PhaseBlobCheck kNoisePilotCheck{most_pilot_bytes, pilot_fault};

}  // namespace tessera::wire

#include "wire/noise_pilot_blob.h"

#include <cstring>

#include "wire/limits.h"

namespace tessera::wire {
namespace {

using Rect = std::array<std::uint32_t, 4>;  // x0, y0, x1, y1

}  // namespace

const PilotBlock* PilotBlocks::at(std::uint32_t x, std::uint32_t y) const {
  const std::uint32_t u = x / kNoiseBlock, v = y / kNoiseBlock;
  if (u < x0 || u >= x1 || v < y0 || v >= y1) return nullptr;
  return &values[std::size_t{v - y0} * (x1 - x0) + (u - x0)];
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
  constexpr std::uint32_t kMostBlocks = kMaxFilmSize / kNoiseBlock;
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

}  // namespace tessera::wire

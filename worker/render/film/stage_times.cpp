#include "render/film/stage_times.h"

#include <algorithm>

namespace tessera::render {

StageTimes& StageTimes::operator+=(const StageTimes& other) {
  for (std::size_t i = 0; i < stages.size(); ++i) stages[i] += other.stages[i];
  for (std::size_t i = 0; i < shading_parts.size(); ++i) shading_parts[i] += other.shading_parts[i];
  materials.resize(std::max(materials.size(), other.materials.size()));
  for (std::size_t i = 0; i < other.materials.size(); ++i) materials[i] += other.materials[i];
  return *this;
}

StageTimes& StageTimes::operator*=(double factor) {
  const auto scale = [factor](auto& times) {
    for (std::uint64_t& time : times) time = static_cast<std::uint64_t>(static_cast<double>(time) * factor);
  };
  scale(stages);
  scale(shading_parts);
  scale(materials);
  return *this;
}

}  // namespace tessera::render

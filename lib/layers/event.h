// Numbers of the points of a path: the symbols of the automaton of layers.
#pragma once

#include <cstdint>

namespace tessera::layers {

/// How a path is scattered at a point.
enum class Event : std::uint8_t {
  kDiffuseReflection,
  kGlossyReflection,
  kSpecularReflection,
  kDiffuseTransmission,
  kGlossyTransmission,
  kSpecularTransmission,
  kVolume
};
inline constexpr int kEvents = 7;
/// From an event of reflection to that of transmission.
inline constexpr std::int32_t kFirstTransmission = 3;

/// Where light comes from.
enum class Source : std::uint8_t { kLamp, kSurface, kBackground, kMedium };
inline constexpr int kSources = 4;

/// Points are numbers: an event at a surface is Event + kEventStride * label of the surface, light is Source
/// + kSources * label of the light. kNoEvent in place of the event leaves every state as it is.
inline constexpr std::int32_t kEventStride = 8;
inline constexpr std::int32_t kNoEvent = 7;

}  // namespace tessera::layers

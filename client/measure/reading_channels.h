// Numbers that a pixel of a probe holds: the same light, weighed in several ways.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tessera::client {

/// Ways to weigh the light of one reading. Those from kRadiant on are of jobs of wavelengths.
enum class ReadingChannel : std::uint8_t {
  kLuminance,  // of linear Rec.709
  kRed,
  kGreen,
  kBlue,
  kRadiant,   // by nothing
  kScotopic,  // by V'(lambda)
  kMelanopic  // by the melanopic action spectrum
};
inline constexpr std::size_t kReadingChannels = 7, kRgbReadingChannels = 4;

using ChannelValues = std::array<double, kReadingChannels>;

}  // namespace tessera::client

#pragma once

#include <cstdint>

namespace tessera::render {

enum class SamplerKind : std::int32_t {
  kSobol,
  kIndependent,
  kZSobol,
  kGroupSobol  // kSobol for groups of kGroupSize pixels whose samples are stratified together
};
inline constexpr std::uint32_t kGroupSize = 16;

struct SamplerConfig {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint64_t seed = 0;
  int sample_bits = 0;  // kZSobol: pixels take up to 2^sample_bits samples; at most 24
};

}  // namespace tessera::render

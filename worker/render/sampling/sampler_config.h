#pragma once

#include <cstdint>

namespace tessera::render {

enum class SamplerKind : std::int32_t { kSobol, kIndependent };

struct SamplerConfig {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint64_t seed = 0;
};

}  // namespace tessera::render

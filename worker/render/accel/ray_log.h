// Rays as they were traced, for measuring how fast they could be traced with no shading at all. Their times are not kept: of
// what moves, it is traced where it is when the shutter opens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera::render {

struct RayLog {
  enum class Kind : std::int32_t { kCamera, kBounce, kShadow };
  /// One call of the tracer.
  struct Call {
    Kind kind;
    bool coherent;
    std::int32_t count;  // rays
    std::size_t first;   // in `data`: arrays of `stride()` floats: origin x y z, direction x y z, distance (kShadow)
    std::size_t stride() const { return (static_cast<std::size_t>(count) + 15) / 16 * 16; }
  };
  std::vector<Call> calls;
  std::vector<float> data;
};

}  // namespace tessera::render

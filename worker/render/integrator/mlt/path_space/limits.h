// What bounds paths that are mutated vertex by vertex.
#pragma once

namespace tessera::render {

/// Most scattering events.
inline constexpr int kMostEvents = 64;

}  // namespace tessera::render

// Caps of layers, for automata and for the arrays of those who read them.
#pragma once

#include <cstddef>

namespace tessera::layers {

/// Most layers of a picture, characters of a layer's name, names of objects, materials and lights, points in
/// all expressions once repetitions are written out, states of the automaton, and entries of its table.
inline constexpr std::size_t kMaxLayers = 32;
inline constexpr std::size_t kMaxName = 64;
inline constexpr std::size_t kMaxNames = 64;
inline constexpr std::size_t kMaxPoints = 1024;
inline constexpr std::size_t kMaxStates = 1024;
inline constexpr std::size_t kMaxEntries = std::size_t{1} << 18;

}  // namespace tessera::layers

// The checksum of what the coordinator keeps on its disk.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace tessera::server {

/// 64 bits of the bytes and of `seed`, which a chain of pieces, or a place, may be. Each step is one-to-one
/// in its word, so that no damage within one word goes unnoticed. Bytes of the last word that are not there
/// count as zeros.
inline std::uint64_t checksum(std::string_view bytes, std::uint64_t seed) {
  std::uint64_t sum = 0xcbf29ce484222325u ^ seed;
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof(word), bytes.size() - at));
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
    sum ^= sum >> 29;
  }
  return sum;
}

}  // namespace tessera::server

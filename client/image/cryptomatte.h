// Cryptomatte: which things a pixel shows, and how much of it each of them covers [Friedman2015; the
// specification, version 1.2].
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "image/image.h"

namespace tessera::client {

/// MurmurHash3_x86_32 of a name, with seed 0 [Appleby 2011].
std::uint32_t matte_hash(std::string_view name);
/// The hash as a pixel's value: its bits, with the lowest of the exponent turned round where the number would
/// be none, infinite or denormal.
float matte_identifier(std::string_view name);

inline constexpr std::uint32_t kMatteRanks = 6;

/// A list of identifiers as results have it (wire::ChannelKind::kEntry: channels "LIST.id0", "LIST.weight0"
/// ...), and the Cryptomatte that it becomes.
struct MatteList {
  std::string list;
  std::string name;
  std::uint32_t ranks = kMatteRanks;  // things that a pixel tells, at most
  /// Names what a number stands for; things of one name are one.
  std::function<std::string(std::int64_t)> name_of;
};

/// Makes a Cryptomatte pixel by pixel, in any order: the things of the largest coverages, two to each of the
/// layers NAME00, NAME01 ... Keeps the names of all things that it met.
class MatteResolver {
 public:
  explicit MatteResolver(MatteList list) : list_(std::move(list)) {}

  /// Names of the planes, "NAME00.R" and so on.
  std::vector<std::string> planes() const;
  /// `entries`: pairs of identifier and weight. `ranks`, a value for each plane, becomes pairs of hash and
  /// coverage, the largest first, then zeros.
  void resolve(std::span<const float> entries, std::span<float> ranks);
  /// Adds the attributes of Cryptomatte. Their manifest is sorted by name, so that it is the same whatever
  /// the order of the pixels.
  void describe(Image& image) const;

 private:
  float identifier_of(float number);

  MatteList list_;
  std::unordered_map<std::uint32_t, float> identifier_by_number_bits_;
  std::map<std::string, float> manifest_;
  std::vector<std::pair<float, float>> pixel_mattes_;  // identifier and coverage
};

}  // namespace tessera::client

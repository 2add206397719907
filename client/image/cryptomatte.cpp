#include "image/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"

namespace tessera::client {
namespace {

std::uint32_t mixed_block(std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; }

/// Identifier and coverage.
using Matte = std::pair<float, float>;

/// Sorts the identifiers of a pixel, the largest coverage first.
void sort_mattes(std::vector<Matte>& mattes) {
  std::ranges::sort(mattes, [](const Matte& a, const Matte& b) {
    if (a.second != b.second) return a.second > b.second;
    return std::bit_cast<std::uint32_t>(a.first) < std::bit_cast<std::uint32_t>(b.first);
  });
}

void add_matte(float identifier, float coverage, std::vector<Matte>& mattes) {
  const auto same = std::ranges::find(mattes, identifier, &Matte::first);
  if (same != mattes.end()) {
    same->second += coverage;
  } else {
    mattes.emplace_back(identifier, coverage);
  }
}

}  // namespace

std::uint32_t matte_hash(std::string_view name) {
  std::uint32_t hash = 0;
  const std::size_t blocks = name.size() / 4;
  for (std::size_t i = 0; i < blocks; ++i) {
    std::uint32_t block;
    std::memcpy(&block, name.data() + 4 * i, sizeof(block));
    hash = std::rotl(hash ^ mixed_block(block), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t tail = 0;
  for (std::size_t i = name.size(); i > 4 * blocks; --i)
    tail = tail << 8 | static_cast<unsigned char>(name[i - 1]);
  if (tail != 0) hash ^= mixed_block(tail);
  hash ^= static_cast<std::uint32_t>(name.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

float matte_identifier(std::string_view name) {
  std::uint32_t hash = matte_hash(name);
  const std::uint32_t exponent = hash >> 23 & 255;
  if (exponent == 0 || exponent == 255) hash ^= 1u << 23;
  return std::bit_cast<float>(hash);
}

std::vector<std::string> MatteResolver::planes() const {
  std::vector<std::string> names;
  for (std::uint32_t layer = 0; layer < (list_.ranks + 1) / 2; ++layer) {
    for (const char* const band : {"R", "G", "B", "A"})
      names.push_back(absl::StrFormat("%s%02u.%s", list_.name, layer, band));
  }
  return names;
}

float MatteResolver::identifier_of(float number) {
  const auto [known, is_new] = identifier_by_number_bits_.try_emplace(std::bit_cast<std::uint32_t>(number));
  if (is_new) {
    constexpr float kMost = 0x1p62f;  // results come from elsewhere
    const std::string name =
        list_.name_of(std::abs(number) < kMost ? static_cast<std::int64_t>(number) : std::int64_t{0});
    known->second = matte_identifier(name);
    manifest_.emplace(name, known->second);
  }
  return known->second;
}

void MatteResolver::resolve(std::span<const float> entries, std::span<float> ranks) {
  pixel_mattes_.clear();
  for (std::size_t entry = 0; entry + 1 < entries.size(); entry += 2) {
    if (const float coverage = entries[entry + 1]; coverage != 0)
      add_matte(identifier_of(entries[entry]), coverage, pixel_mattes_);
  }
  sort_mattes(pixel_mattes_);
  std::ranges::fill(ranks, 0.0f);
  for (std::size_t rank = 0; rank < std::min<std::size_t>(pixel_mattes_.size(), list_.ranks); ++rank) {
    // Filters with negative lobes give coverages below 0, and above 1.
    const float coverage = std::clamp(pixel_mattes_[rank].second, 0.0f, 1.0f);
    if (coverage == 0) break;
    ranks[2 * rank] = pixel_mattes_[rank].first;
    ranks[2 * rank + 1] = coverage;
  }
}

void MatteResolver::describe(Image& image) const {
  nlohmann::json manifest = nlohmann::json::object();
  for (const auto& [name, identifier] : manifest_)
    manifest[name] = absl::StrFormat("%08x", std::bit_cast<std::uint32_t>(identifier));
  const std::string key = absl::StrFormat("cryptomatte/%07x/", matte_hash(list_.name) >> 4);
  image.metadata[key + "name"] = list_.name;
  image.metadata[key + "hash"] = std::string("MurmurHash3_32");
  image.metadata[key + "conversion"] = std::string("uint32_to_float32");
  // Names are what the author wrote, in whatever encoding.
  image.metadata[key + "manifest"] = manifest.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace tessera::client

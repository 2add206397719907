#include "image/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"

namespace tessera::client {
namespace {

std::uint32_t mixed_block(std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; }

/// The names so far.
class Manifest {
 public:
  explicit Manifest(const std::function<std::string(std::int64_t)>& name_of) : name_of_(name_of) {}

  float identifier_of(float number) {
    const auto known = identifiers_.find(number);
    if (known != identifiers_.end()) return known->second;
    const std::string name = name_of_(static_cast<std::int64_t>(number));
    const float identifier = matte_identifier(name);
    json_[name] = absl::StrFormat("%08x", std::bit_cast<std::uint32_t>(identifier));
    return identifiers_[number] = identifier;
  }
  /// Names are what the author wrote, in whatever encoding.
  std::string text() const {
    return json_.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  }

 private:
  const std::function<std::string(std::int64_t)>& name_of_;
  std::map<float, float> identifiers_;
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

/// Identifier and coverage.
using Matte = std::pair<float, float>;

/// Those of a pixel, the largest first.
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

void resolve_mattes(std::string_view list, const std::string& name, std::uint32_t ranks,
                    const std::function<std::string(std::int64_t)>& name_of, Image& image) {
  const std::string prefix = std::string(list) + ".";
  std::vector<Channel> raw;
  std::vector<Channel> others;
  for (Channel& channel : image.channels)
    (channel.name.starts_with(prefix) ? raw : others).push_back(std::move(channel));
  image.channels = std::move(others);
  if (raw.size() < 2) return;
  const std::size_t first = image.channels.size();
  for (std::uint32_t layer = 0; layer < (ranks + 1) / 2; ++layer) {
    for (const char* const band : {"R", "G", "B", "A"})
      image.add(absl::StrFormat("%s%02u.%s", name, layer, band));
  }
  Manifest manifest(name_of);
  std::vector<Matte> mattes;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    mattes.clear();
    for (std::size_t entry = 0; entry + 1 < raw.size(); entry += 2) {
      if (const float coverage = raw[entry + 1].values[i]; coverage != 0)
        add_matte(manifest.identifier_of(raw[entry].values[i]), coverage, mattes);
    }
    sort_mattes(mattes);
    for (std::size_t rank = 0; rank < std::min<std::size_t>(mattes.size(), ranks); ++rank) {
      // Filters with negative lobes give coverages below 0, and above 1.
      const float coverage = std::clamp(mattes[rank].second, 0.0f, 1.0f);
      if (coverage == 0) break;
      image.channels[first + 2 * rank].values[i] = mattes[rank].first;
      image.channels[first + 2 * rank + 1].values[i] = coverage;
    }
  }
  const std::string key = absl::StrFormat("cryptomatte/%07x/", matte_hash(name) >> 4);
  image.metadata[key + "name"] = name;
  image.metadata[key + "hash"] = std::string("MurmurHash3_32");
  image.metadata[key + "conversion"] = std::string("uint32_to_float32");
  image.metadata[key + "manifest"] = manifest.text();
}

}  // namespace tessera::client

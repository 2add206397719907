#include "image/exr/part.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "absl/strings/str_cat.h"
#include "image/exr/channel_names.h"

namespace tessera::client {
namespace {

/// Counts, numbers, distances and places need more digits than a half has.
bool needs_float(std::string_view name) {
  constexpr std::string_view kExactLayers[] = {"depth", "id", "position", "uv"};
  return name == "samples" || is_cryptomatte(name) ||
         std::ranges::find(kExactLayers, layer_of(name)) != std::end(kExactLayers);
}

bool names_channel(std::string_view word, std::string_view channel) {
  if (word == "rgba") return channel == "R" || channel == "G" || channel == "B" || channel == "A";
  return word == channel || word == layer_of(channel);
}

bool stored_as_half(std::string_view name, const ExrFormat& format) {
  const bool named = std::ranges::any_of(format.half_layers,
                                         [&](const std::string& word) { return names_channel(word, name); });
  return (named && !is_cryptomatte(name)) || (format.half && !needs_float(name));
}

bool has_loss(ExrCompression compression) {
  return compression == ExrCompression::kDwaa || compression == ExrCompression::kDwab;
}

bool is_number(std::string_view name) { return layer_of(name) == "id" || is_cryptomatte(name); }

}  // namespace

std::size_t ExrPart::bytes() const {
  return std::accumulate(channels.begin(), channels.end(), std::size_t{0},
                         [](std::size_t sum, const PartChannel& channel) { return sum + channel.bytes(); });
}

absl::StatusOr<std::vector<ExrPart>> parts_of(const Image& image, const ExrFormat& format) {
  std::map<std::string, ExrPart> part_by_layer;  // keys are our own names, so that the picture comes first
  std::set<std::string> names;
  for (std::size_t plane = 0; plane < image.channels.size(); ++plane) {
    const std::string& own = image.channels[plane].name;
    const std::string layer(format.multipart ? layer_of(own) : "");
    ExrPart& part = part_by_layer[layer];
    PartChannel channel{.name = channel_name(own, format.names),
                        .plane = plane,
                        .half = stored_as_half(own, format),
                        .averages = !is_number(own)};
    if (own.empty() || !names.insert(channel.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("channel name '", channel.name, "' is empty or there twice"));
    }
    part.name = layer_of(channel.name);
    if (part.name.empty()) part.name = layer.empty() ? "rgba" : layer;
    part.compression = format.compression;
    part.dwa_level = format.dwa_level;
    if (has_loss(format.compression) && is_cryptomatte(own)) {
      if (!format.multipart) {
        return absl::InvalidArgumentError(
            "Cryptomatte cannot be compressed with loss: have parts (--multipart), or another compression");
      }
      part.compression = ExrCompression::kZip;
    }
    part.channels.push_back(std::move(channel));
  }
  std::vector<ExrPart> parts;
  for (auto& [layer, part] : part_by_layer) {
    std::ranges::sort(part.channels, {}, &PartChannel::name);
    parts.push_back(std::move(part));
  }
  if (parts.size() == 1) parts.front().name.clear();
  return parts;
}

}  // namespace tessera::client

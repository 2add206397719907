#include "wire/aov_channels.h"

#include <algorithm>

#include "wire/colour_channels.h"
#include "wire/enum_words.h"
#include "wire/film_sensor.h"

namespace tessera::wire {
namespace {

/// A list of identifiers; `of` is set when it is known where the list begins.
std::vector<ChannelDesc> list_of(const std::string& name) {
  std::vector<ChannelDesc> channels;
  for (std::size_t entry = 0; entry < kListEntries; ++entry) {
    const ChannelKind kind = entry == 0 ? ChannelKind::kEntry : ChannelKind::kFurtherEntry;
    const std::string number = std::to_string(entry);
    channels.push_back({name + ".id" + number, kind});
    channels.push_back({name + ".weight" + number, kind});
  }
  return channels;
}

/// Channels of a layer; ChannelDesc::of is the channel of the picture that each belongs to.
std::vector<ChannelDesc> colours_of(const std::string& layer, ChannelKind kind = ChannelKind::kSum) {
  std::vector<ChannelDesc> channels;
  for (const std::string& name : colour_channels_of(layer)) {
    const bool of_another = kind == ChannelKind::kSquaredDeviation;
    channels.push_back({name, kind, static_cast<std::uint8_t>(of_another ? channels.size() : 0)});
  }
  return channels;
}

std::vector<ChannelDesc> channels_of(v1::AOV aov) {
  if (aov == v1::AOV_VARIANCE) return colours_of("variance", ChannelKind::kSquaredDeviation);
  const HitAovRow* const row = find_hit_aov(aov);
  if (row == nullptr)
    return {};  // counts and alpha come with every result; halves are those of other channels
  if (row->kind == ChannelKind::kEntry) return list_of(row->channels[0]);
  std::vector<ChannelDesc> channels;
  for (int i = 0; i < row->channel_count(); ++i) channels.push_back({row->channels[i], row->kind});
  return channels;
}

}  // namespace

std::vector<ChannelDesc> channels_for_aovs(std::vector<v1::AOV> aovs) {
  std::sort(aovs.begin(), aovs.end());
  aovs.erase(std::unique(aovs.begin(), aovs.end()), aovs.end());
  std::vector<ChannelDesc> channels;
  for (const char* const name : kColourChannels) channels.push_back({name});
  channels.push_back({"A"});
  for (const v1::AOV aov : aovs) {
    std::vector<ChannelDesc> added = channels_of(aov);
    if (!added.empty() && added.front().kind == ChannelKind::kEntry) {
      for (ChannelDesc& channel : added) channel.of = static_cast<std::uint8_t>(channels.size());
    }
    channels.insert(channels.end(), added.begin(), added.end());
  }
  if (std::ranges::binary_search(aovs, v1::AOV_HALVES)) {
    std::vector<ChannelDesc> halves = colours_of("half");
    for (const v1::AOV aov : aovs) {
      if (aov != v1::AOV_ALBEDO && aov != v1::AOV_NORMAL && aov != v1::AOV_DEPTH) continue;
      for (const ChannelDesc& whole : channels_of(aov)) halves.push_back({.name = "half." + whole.name});
    }
    channels.insert(channels.end(), halves.begin(), halves.end());
  }
  return channels;
}

std::vector<ChannelDesc> channels_of(const v1::JobSpec::View& view) {
  std::vector<v1::AOV> aovs;
  for (const int aov : view.aovs()) aovs.push_back(static_cast<v1::AOV>(aov));
  std::vector<ChannelDesc> channels = channels_for_aovs(std::move(aovs));
  const spectra::Bands bands = bands_of(view);
  for (int band = 0; band < bands.count; ++band)
    channels.push_back({.name = spectra::band_channel(bands.centre(band))});
  for (const v1::Layer& layer : view.layers()) {
    for (const std::string& name : colour_channels_of(layer.name())) channels.push_back({.name = name});
  }
  return channels;
}

std::vector<layers::Layer> layers_of(const v1::JobSpec::View& view) {
  std::vector<layers::Layer> layers;
  for (const v1::Layer& layer : view.layers()) layers.push_back({layer.name(), layer.expression()});
  return layers;
}

const HitAovRow* find_hit_aov(v1::AOV aov) { return find_hit_aov(word_of(aov)); }

bool is_first_hit(v1::AOV aov) { return find_hit_aov(aov) != nullptr || aov == v1::AOV_HALVES; }

bool is_cryptomatte(v1::AOV aov) {
  const HitAovRow* const row = find_hit_aov(aov);
  return row != nullptr && row->kind == ChannelKind::kEntry;
}

}  // namespace tessera::wire

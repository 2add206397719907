#include "image/exr/channel_names.h"

#include "spectra/sensor/bands.h"

namespace tessera::client {
namespace {

/// The same layer for each program; empty: there it has no name of its own. Bands follow behind a point, but
/// for names with a band of their own.
struct LayerNames {
  std::string_view own, blender, nuke, mitsuba;
};

constexpr LayerNames kLayerNames[] = {
    {"", "Combined", "", ""},
    {"albedo", "Denoising Albedo", "", ""},
    {"depth", "Depth", "", "depth"},
    {"normal", "Normal", "N", "sh_normal"},
    {"camera-normal", "", "Ncamera", ""},
    {"position", "Position", "P", "position"},
    {"uv", "UV", "", "uv"},
    {"motion", "Vector", "forward", ""},
};

struct WholeName {
  ChannelNames names;
  std::string_view own, name;
};

/// Channels whose bands have other letters, too.
constexpr WholeName kWholeNames[] = {
    {ChannelNames::kBlender, "id.shape", "ViewLayer.IndexOB.X"},
    {ChannelNames::kBlender, "id.instance", "ViewLayer.IndexInstance.X"},
    {ChannelNames::kBlender, "id.material", "ViewLayer.IndexMA.X"},
    {ChannelNames::kBlender, "samples", "ViewLayer.Debug Sample Count.X"},
    {ChannelNames::kBlender, "motion.U", "ViewLayer.Vector.X"},
    {ChannelNames::kBlender, "motion.V", "ViewLayer.Vector.Y"},
    {ChannelNames::kNuke, "depth.Z", "Z"},
    {ChannelNames::kNuke, "motion.U", "forward.u"},
    {ChannelNames::kNuke, "motion.V", "forward.v"},
    {ChannelNames::kMitsuba, "depth.Z", "depth.T"},
    {ChannelNames::kMitsuba, "id.shape", "shape_index.I"},
};

std::string_view name_for(const LayerNames& layer, ChannelNames names) {
  if (names == ChannelNames::kBlender) return layer.blender;
  return names == ChannelNames::kNuke ? layer.nuke : layer.mitsuba;
}

/// Blender's Cryptomatte reads bands in small letters.
std::string band_for(std::string_view own, std::string_view band, ChannelNames names) {
  std::string result(band);
  if (names == ChannelNames::kBlender && is_cryptomatte(own)) result[0] = static_cast<char>(result[0] | 0x20);
  return result;
}

}  // namespace

std::string_view layer_of(std::string_view channel) {
  const std::size_t dot = channel.rfind('.');
  return dot == std::string_view::npos ? "" : channel.substr(0, dot);
}

bool is_cryptomatte(std::string_view channel) { return channel.starts_with("Crypto"); }

std::string channel_name(std::string_view own, ChannelNames names) {
  // Bands have the names of their layout, wherever they go.
  if (names == ChannelNames::kTessera || spectra::centre_of_channel(own)) return std::string(own);
  for (const WholeName& whole : kWholeNames) {
    if (whole.names == names && whole.own == own) return std::string(whole.name);
  }
  const std::string_view layer = layer_of(own), band = own.substr(layer.empty() ? 0 : layer.size() + 1);
  std::string_view name = layer;
  for (const LayerNames& known : kLayerNames) {
    if (known.own == layer && !name_for(known, names).empty()) name = name_for(known, names);
  }
  const std::string tail =
      name.empty() ? std::string(band) : std::string(name) + "." + band_for(own, band, names);
  return names == ChannelNames::kBlender ? "ViewLayer." + tail : tail;
}

}  // namespace tessera::client

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/exr.h"

namespace tessera::client {
namespace {

Imath::Box2i box_of(const Window& window) { return {{window.x0, window.y0}, {window.x1 - 1, window.y1 - 1}}; }

absl::Status check(const Image& image, const std::string& path) {
  const auto fail = [&](auto... what) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", what...));
  };
  for (const Window& window : {image.data, image.display}) {
    if (window.x1 <= window.x0 || window.y1 <= window.y0) return fail("the image is empty");
  }
  if (image.channels.empty()) return fail("the image has no channels");
  std::set<std::string> names;
  for (const Channel& channel : image.channels) {
    if (channel.name.empty() || !names.insert(channel.name).second) {
      return fail("channel name '", channel.name, "' is empty or there twice");
    }
    if (channel.values.size() != image.pixel_count())
      return fail("channel ", channel.name, " has the wrong size");
  }
  return absl::OkStatus();
}

// Counts, numbers and distances need more digits than a half has.
bool stored_as_half(const std::string& name, PixelType type) {
  return type == PixelType::kHalf && name != "samples" && !absl::StartsWith(name, "depth.") &&
         !absl::StartsWith(name, "id.");
}

std::vector<Imath::half> to_half(const std::vector<float>& values) {
  std::vector<Imath::half> halves(values.size());
  std::ranges::transform(values, halves.begin(), [](float value) {
    constexpr float kMax = 65504;
    return Imath::half(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
  });
  return halves;
}

using Channels = std::vector<const Channel*>;

/// The layer that a channel's name tells: "a.b" of "a.b.R"; empty: none.
std::string layer_of(const Channel& channel) {
  const std::size_t dot = channel.name.rfind('.');
  return dot == std::string::npos ? "" : channel.name.substr(0, dot);
}

/// Those of each part, by its name.
std::map<std::string, Channels> parts_of(const Image& image, ExrParts parts) {
  std::map<std::string, Channels> result;
  for (const Channel& channel : image.channels)
    result[parts == ExrParts::kMany ? layer_of(channel) : ""].push_back(&channel);
  return result;
}

Imf::Header make_header(const Image& image, const Channels& channels, PixelType type) {
  Imf::Header header(box_of(image.display), box_of(image.data));
  header.compression() = Imf::ZIP_COMPRESSION;
  // Rec.709 is what a file without this attribute is taken for; saying so costs nothing.
  Imf::addChromaticities(header, Imf::Chromaticities());
  for (const Channel* const channel : channels) {
    header.channels().insert(channel->name,
                             Imf::Channel(stored_as_half(channel->name, type) ? Imf::HALF : Imf::FLOAT));
  }
  for (const auto& [name, value] : image.metadata) {
    if (const auto* text = std::get_if<std::string>(&value)) header.insert(name, Imf::StringAttribute(*text));
    if (const auto* number = std::get_if<std::int32_t>(&value))
      header.insert(name, Imf::IntAttribute(*number));
    if (const auto* real = std::get_if<float>(&value)) header.insert(name, Imf::FloatAttribute(*real));
  }
  return header;
}

/// Writes the channels to `output`, a file or a part of one.
template <class Output>
void write_channels(const Image& image, const Channels& channels, PixelType type, Output& output) {
  // OpenEXR addresses pixels from the origin of the coordinate system: Slice::Make takes care of that.
  std::vector<std::vector<Imath::half>> halves;
  halves.reserve(channels.size());
  Imf::FrameBuffer frame;
  for (const Channel* const channel : channels) {
    const bool half = stored_as_half(channel->name, type);
    const void* data = channel->values.data();
    if (half) data = halves.emplace_back(to_half(channel->values)).data();
    frame.insert(channel->name, Imf::Slice::Make(half ? Imf::HALF : Imf::FLOAT, data, box_of(image.data)));
  }
  output.setFrameBuffer(frame);
  output.writePixels(image.data.height());
}

void write_file(const Image& image, const std::string& file, PixelType type, ExrParts wanted) {
  const std::map<std::string, Channels> parts = parts_of(image, wanted);
  if (parts.size() == 1) {
    const Channels& channels = parts.begin()->second;
    Imf::OutputFile output(file.c_str(), make_header(image, channels, type));
    write_channels(image, channels, type, output);
    return;
  }
  std::vector<Imf::Header> headers;
  for (const auto& [name, channels] : parts) {
    Imf::Header& header = headers.emplace_back(make_header(image, channels, type));
    header.setName(name.empty() ? "rgba" : name);
    header.setType(Imf::SCANLINEIMAGE);
  }
  Imf::MultiPartOutputFile output(file.c_str(), headers.data(), static_cast<int>(headers.size()));
  int number = 0;
  for (const auto& [name, channels] : parts) {
    Imf::OutputPart part(output, number++);
    write_channels(image, channels, type, part);
  }
}

}  // namespace

absl::Status write_exr(const Image& image, const std::string& path, PixelType type, ExrParts parts) {
  if (absl::Status status = check(image, path); !status.ok()) return status;
  return replace_file(path, [&](const std::string& file) {
    try {
      write_file(image, file, type, parts);
      return absl::OkStatus();
    } catch (const std::exception& error) {
      return absl::InternalError(absl::StrCat(path, ": cannot write: ", error.what()));
    }
  });
}

}  // namespace tessera::client

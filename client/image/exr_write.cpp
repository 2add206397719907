#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
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

// Counts and distances need more digits than a half has.
bool stored_as_half(const std::string& name, PixelType type) {
  return type == PixelType::kHalf && name != "samples" && !absl::StartsWith(name, "depth.");
}

std::vector<Imath::half> to_half(const std::vector<float>& values) {
  std::vector<Imath::half> halves(values.size());
  std::ranges::transform(values, halves.begin(), [](float value) {
    constexpr float kMax = 65504;
    return Imath::half(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
  });
  return halves;
}

Imf::Header make_header(const Image& image, PixelType type) {
  Imf::Header header(box_of(image.display), box_of(image.data));
  header.compression() = Imf::ZIP_COMPRESSION;
  // Rec.709 is what a file without this attribute is taken for; saying so costs nothing.
  Imf::addChromaticities(header, Imf::Chromaticities());
  for (const Channel& channel : image.channels) {
    header.channels().insert(channel.name,
                             Imf::Channel(stored_as_half(channel.name, type) ? Imf::HALF : Imf::FLOAT));
  }
  for (const auto& [name, value] : image.metadata) {
    if (const auto* text = std::get_if<std::string>(&value)) header.insert(name, Imf::StringAttribute(*text));
    if (const auto* number = std::get_if<std::int32_t>(&value))
      header.insert(name, Imf::IntAttribute(*number));
    if (const auto* real = std::get_if<float>(&value)) header.insert(name, Imf::FloatAttribute(*real));
  }
  return header;
}

void write_file(const Image& image, const std::string& file, PixelType type) {
  // OpenEXR addresses pixels from the origin of the coordinate system: Slice::Make takes care of that.
  std::vector<std::vector<Imath::half>> halves;
  halves.reserve(image.channels.size());
  Imf::FrameBuffer frame;
  for (const Channel& channel : image.channels) {
    const void* data = channel.values.data();
    if (stored_as_half(channel.name, type)) data = halves.emplace_back(to_half(channel.values)).data();
    frame.insert(channel.name, Imf::Slice::Make(stored_as_half(channel.name, type) ? Imf::HALF : Imf::FLOAT,
                                                data, box_of(image.data)));
  }
  Imf::OutputFile output(file.c_str(), make_header(image, type));
  output.setFrameBuffer(frame);
  output.writePixels(image.data.height());
}

}  // namespace

absl::Status write_exr(const Image& image, const std::string& path, PixelType type) {
  if (absl::Status status = check(image, path); !status.ok()) return status;
  return replace_file(path, [&](const std::string& file) {
    try {
      write_file(image, file, type);
      return absl::OkStatus();
    } catch (const std::exception& error) {
      return absl::InternalError(absl::StrCat(path, ": cannot write: ", error.what()));
    }
  });
}

}  // namespace tessera::client

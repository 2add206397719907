#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include <exception>
#include <set>
#include <string>

#include "images/memory_stream.h"
#include "images/readers.h"

namespace tessera::images {
namespace {

/// Whether the channels are R, G, B, with A or without, or Y alone, each of halves or floats at every pixel.
bool plain(const Imf::ChannelList& channels) {
  std::set<std::string> names;
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const Imf::Channel& channel = c.channel();
    if (channel.xSampling != 1 || channel.ySampling != 1 || channel.type == Imf::UINT) return false;
    names.insert(c.name());
  }
  return names == std::set<std::string>{"R", "G", "B"} ||
         names == std::set<std::string>{"R", "G", "B", "A"} || names == std::set<std::string>{"Y"};
}

bool read(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  MemoryStream memory(blob);
  Imf::MultiPartInputFile file(memory);
  if (file.parts() != 1) return false;
  const Imf::Header& header = file.header(0);
  if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE)
    return false;
  if (!plain(header.channels())) return false;
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (!allot(width, height, true, max_pixels, pixels)) return false;

  constexpr std::size_t kPixel = 4 * sizeof(float);
  const auto row = kPixel * static_cast<std::size_t>(width);
  // OpenEXR addresses pixels by their coordinates; those of the window begin where the array does.
  char* const origin = reinterpret_cast<char*>(pixels.floats.data()) -
                       static_cast<std::ptrdiff_t>(kPixel) * window.min.x -
                       static_cast<std::ptrdiff_t>(row) * window.min.y;
  const bool grey = header.channels().findChannel("Y") != nullptr;
  Imf::FrameBuffer buffer;
  const char* const names[] = {grey ? "Y" : "R", "G", "B", "A"};
  for (std::size_t c = 0; c < (grey ? 1 : 4); ++c) {
    buffer.insert(names[c], Imf::Slice(Imf::FLOAT, origin + c * sizeof(float), kPixel, row, 1, 1, 1.0));
  }
  Imf::InputPart part(file, 0);
  part.setFrameBuffer(buffer);
  part.readPixels(window.min.y, window.max.y);
  if (!grey) return true;
  for (std::size_t i = 0; i < pixels.floats.size(); i += 4) {
    pixels.floats[i + 1] = pixels.floats[i + 2] = pixels.floats[i];
    pixels.floats[i + 3] = 1;
  }
  return true;
}

}  // namespace

bool read_exr(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  try {
    return read(blob, max_pixels, pixels);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace tessera::images

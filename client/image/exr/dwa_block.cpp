#include "image/exr/dwa_block.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfTileDescriptionAttribute.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <exception>

#include "image/exr/exr_file.h"

namespace tessera::client {
namespace {

/// A file of one tile, in memory; written without threads.
std::string file_of(const ExrPart& part, std::span<const unsigned char> block, std::int32_t width,
                    std::int32_t height) {
  Imf::Header header(width, height);
  header.compression() =
      part.compression == ExrCompression::kDwaa ? Imf::DWAA_COMPRESSION : Imf::DWAB_COMPRESSION;
  header.dwaCompressionLevel() = part.dwa_level;
  header.setTileDescription(
      Imf::TileDescription(static_cast<unsigned>(width), static_cast<unsigned>(height)));
  Imf::FrameBuffer frame;
  // The library takes all pixels to be changeable; it reads these.
  char* at = const_cast<char*>(reinterpret_cast<const char*>(block.data()));
  for (const PartChannel& channel : part.channels) {
    const Imf::PixelType type = channel.half ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(channel.name, Imf::Channel(type));
    frame.insert(channel.name,
                 Imf::Slice(type, at, channel.bytes(), static_cast<std::size_t>(width) * part.bytes()));
    at += static_cast<std::size_t>(width) * channel.bytes();
  }
  Imf::StdOSStream bytes;
  {
    Imf::TiledOutputFile file(bytes, header, 0);
    file.setFrameBuffer(frame);
    file.writeTile(0, 0);
  }
  return bytes.str();
}

}  // namespace

std::span<const unsigned char> DwaBlockPacker::pack(std::span<const unsigned char> block, std::int32_t width,
                                                    std::int32_t height) {
  try {
    Imf::StdISStream bytes;
    bytes.str(file_of(part_, block, width, height));
    Imf::TiledInputFile file(bytes, 0);
    int place[4] = {0, 0, 0, 0}, size = 0;
    const char* data = nullptr;
    file.rawTileData(place[0], place[1], place[2], place[3], data, size);
    packed_.assign(data, data + size);
  } catch (const std::exception& error) {
    throw WriteError(error.what());
  }
  return packed_;
}

}  // namespace tessera::client

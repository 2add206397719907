#include "command/report/exr_options.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command/read_option.h"
#include "wire/settings.h"
#include "wire/tile_result.h"

namespace tessera::client {
namespace {

/// Attributes that say how a file is laid out, or have another type than text.
constexpr std::string_view kTaken[] = {"adoptedNeutral",
                                       "aperture",
                                       "cameraCCTSetting",
                                       "channels",
                                       "chromaticities",
                                       "effectiveFocalLength",
                                       "emissiveUnits",
                                       "entrancePupilOffset",
                                       "spectralLayoutVersion",
                                       "chunkCount",
                                       "compression",
                                       "dataWindow",
                                       "displayWindow",
                                       "expTime",
                                       "focus",
                                       "framesPerSecond",
                                       "isoSpeed",
                                       "lineOrder",
                                       "name",
                                       "pinholeFocalLength",
                                       "pixelAspectRatio",
                                       "renderingTime",
                                       "screenWindowCenter",
                                       "screenWindowWidth",
                                       "sensorOverallDimensions",
                                       "shutterAngle",
                                       "tStop",
                                       "tiles",
                                       "timeCode",
                                       "type",
                                       "utcOffset",
                                       "version",
                                       "view",
                                       "whiteLuminance",
                                       "worldToCamera",
                                       "worldToNDC"};

absl::Status take_attribute(const std::string& text, ExrFormat& exr) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals > 255)
    return absl::InvalidArgumentError("expected NAME=TEXT, with a name of 255 bytes at most");
  const std::string name = text.substr(0, equals);
  if (std::ranges::find(kTaken, name) != std::end(kTaken) || name.starts_with("tessera.") ||
      name.starts_with("cryptomatte/"))
    return absl::InvalidArgumentError("'" + name + "' is what the program writes itself");
  exr.attributes.emplace_back(name, text.substr(equals + 1));
  return absl::OkStatus();
}

}  // namespace

void define_exr_options(options::Command& command, ExrFormat& exr) {
  constexpr double kLeastTile = 8, kMostTile = 4096;
  command.add_flag("--half", exr.half, "16-bit EXR");
  command.add("--half-layers", exr.half_layers, "16 bits for these layers or channels only: rgba, albedo")
      .separated_by_commas()
      .type_name("NAME,...");
  command.add_flag("--multipart", exr.multipart, "EXR with a part for each layer");
  const WordList<ExrCompression> compressions = {
      {"none", ExrCompression::kNone}, {"rle", ExrCompression::kRle}, {"zips", ExrCompression::kZips},
      {"zip", ExrCompression::kZip},   {"piz", ExrCompression::kPiz}, {"dwaa", ExrCompression::kDwaa},
      {"dwab", ExrCompression::kDwab}};
  const WordList<ChannelNames> conventions = {{"tessera", ChannelNames::kTessera},
                                              {"blender", ChannelNames::kBlender},
                                              {"nuke", ChannelNames::kNuke},
                                              {"mitsuba", ChannelNames::kMitsuba}};
  add_choice(command, "--exr-compression", compressions, exr.compression,
             "of an EXR: none, rle, zips, zip, piz, or with loss dwaa, dwab (default: zip)");
  add_choice(command, "--channel-names", conventions, exr.names,
             "names of an EXR's channels: tessera, blender, nuke or mitsuba (default: tessera)");
  const options::Option tiles =
      command.add("--exr-tiles", exr.tile_size, "EXR in tiles of this side, pixels; absent: scanlines")
          .in_range(kLeastTile, kMostTile);
  const auto take_memory = [&exr](const std::string& text) {
    const auto bytes = wire::parse_bytes(text);
    if (bytes.ok()) exr.frame_memory = *bytes;
    return bytes.status();
  };
  command
      .add_read_by("--frame-memory", take_memory,
                   "pixels of a larger picture wait in a temporary file, tile by tile (default: 1G, or a "
                   "quarter of the memory that is free, where that is less)")
      .type_name("SIZE");
  command.add("--crypto-ranks", exr.matte_ranks, "things that a pixel of a Cryptomatte tells, at most")
      .in_range(1, wire::kListEntries)
      .with_default();
  command
      .add_list_read_by(
          "--attribute", [&exr](const std::string& text) { return take_attribute(text, exr); },
          [&exr] { exr.attributes.clear(); }, "a text for an EXR's header: owner=Studio; may be repeated")
      .type_name("NAME=TEXT");
  command.add_flag("--exr-mipmaps", exr.mipmaps, "half as large again and again, too").needs(tiles);
}

options::Option define_multiview(options::Command& command, ExrFormat& exr) {
  return command.add_flag("--multiview", exr.multiview, "one EXR with a part for each view");
}

}  // namespace tessera::client

// OpenEXR files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/image.h"

namespace tessera::client {

enum class ExrCompression { kNone, kRle, kZips, kZip, kPiz, kDwaa, kDwab };

/// Whose names channels have in the file (exr/channel_names.h).
enum class ChannelNames { kTessera, kBlender, kNuke, kMitsuba };

/// How an EXR is written.
struct ExrFormat {
  // 16 bits for all channels but counts, numbers, distances and places; finite values beyond +-65504 are
  // stored as +-65504.
  bool half = false;
  std::vector<std::string> half_layers{};  // the same for these alone: "rgba", "albedo", "normal.X"
  bool multipart = false;                  // a part for each layer: "diffuse" has diffuse.R ...
  bool multiview = false;                  // views of one scene are parts of one file
  ExrCompression compression = ExrCompression::kZip;
  float dwa_level = 45;  // of kDwaa and kDwab: the larger, the smaller the file and the greater the loss
  ChannelNames names = ChannelNames::kTessera;
  std::uint32_t tile_size = 0;    // pixels each way; 0: scanlines
  bool mipmaps = false;           // only with tiles: each level half as large, a mean of four pixels
  std::uint32_t matte_ranks = 6;  // things that a pixel of Cryptomatte tells (image/cryptomatte.h)
  // Pixels of a larger frame are kept in a temporary file until they are written, bytes; absent: by what the
  // machine has.
  std::optional<std::uint64_t> frame_memory{};
  // Texts beside the image's own metadata.
  std::vector<std::pair<std::string, std::string>> attributes{};
};

/// Writes a file of one or several parts. The image's windows become dataWindow and displayWindow. The file
/// is replaced as a whole (atomic_file.h). InvalidArgument when planes do not fit the windows, or
/// Cryptomatte's identifiers would be in a part that is compressed with loss; Internal, with the file's name,
/// when the disk does not take it.
absl::Status write_exr(const Image& image, const std::string& path, const ExrFormat& format = {});

inline constexpr std::size_t kMostImagePixels = std::size_t{1} << 28;

/// Reads the first part of any flat file, and the channels of all parts that have the same pixels and view:
/// half, float or 32-bit integer, scanlines or tiles (the full-resolution level), RGB, luminance or
/// luminance/chroma. Attributes of the types that metadata have become metadata. With a `view`, the first
/// part of that view stands for the first of the file. NotFound when there is no such file; InvalidArgument,
/// with the file's name, for a file that is broken, deep, or larger than `max_pixels`, and with the names of
/// its views where it has not this one. Never throws.
absl::StatusOr<Image> read_exr(const std::string& path, std::size_t max_pixels = kMostImagePixels,
                               const std::string& view = "");

/// The same without pixels: windows and metadata.
absl::StatusOr<Image> read_exr_facts(const std::string& path);

}  // namespace tessera::client

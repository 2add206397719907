#include "capture/set_writer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/color_space.h"
#include "image/png.h"
#include "light_field/tile_pixels.h"
#include "wire/digest.h"

namespace tessera::client {
namespace fs = std::filesystem;
namespace {

constexpr const char* kColours[] = {"R", "G", "B"};

/// The channels of a set alone. Depths are means over all samples of a pixel, and become those of the samples
/// that met something.
absl::StatusOr<Image> set_picture(const Image& picture) {
  Image image;
  image.data = image.display = {0, 0, picture.data.width(), picture.data.height()};
  for (const char* const name : {"R", "G", "B", "A", "depth.Z"}) {
    const Channel* const channel = picture.find(name);
    if (channel == nullptr)
      return absl::InternalError(absl::StrCat("a picture of the set has no channel ", name));
    image.channels.push_back(*channel);
  }
  if (const auto space = picture.metadata.find(kChromaticities); space != picture.metadata.end())
    image.metadata.insert(*space);
  const std::vector<float>& alpha = image.channels[3].values;
  std::vector<float>& depth = image.channels[4].values;
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = alpha[i] > 0 ? depth[i] / alpha[i] : 0;
  return image;
}

}  // namespace

SetWriter::SetWriter(std::string folder, light_field::Manifest& manifest)
    : folder_(std::move(folder)), manifest_(manifest) {}

ExrFormat SetWriter::format() const {
  ExrFormat format;
  format.half = manifest_.half;
  format.tile_size = manifest_.tile_size;
  format.dwa_level = static_cast<float>(manifest_.dwa_level);
  switch (manifest_.compression) {
    case light_field::Compression::kNone:
      format.compression = ExrCompression::kNone;
      break;
    case light_field::Compression::kDwaa:
      format.compression = ExrCompression::kDwaa;
      break;
    default:
      format.compression = ExrCompression::kZip;
  }
  return format;
}

absl::Status SetWriter::begin() const {
  const fs::path manifest = fs::path(folder_) / light_field::kManifestFile;
  std::error_code error;
  if (fs::exists(manifest, error))
    return absl::FailedPreconditionError(absl::StrCat(manifest.string(), " is there already"));
  fs::create_directories(fs::path(folder_) / light_field::kDataFolder, error);
  if (error) return absl::InternalError(absl::StrCat(folder_, ": ", error.message()));
  return absl::OkStatus();
}

absl::Status SetWriter::write(std::uint32_t number, const Image& picture) {
  const absl::StatusOr<Image> image = set_picture(picture);
  if (!image.ok()) return image.status();
  if (image->metadata.contains(kChromaticities)) {
    manifest_.colour_space = "linear, of the primaries in the attribute chromaticities of the files";
  } else if (picture.metadata.contains(kRawChannels)) {
    manifest_.colour_space = "a sensor's own";
  }
  const std::string path =
      (fs::path(folder_) / light_field::kDataFolder / absl::StrCat("view-", number, ".tmp")).string();
  if (absl::Status s = write_exr(*image, path, format()); !s.ok()) return s;
  const auto file = light_field::TileFileReader::open(path);
  if (!file.ok()) return file.status();
  auto tiles = (*file)->tiles();
  if (!tiles.ok()) return tiles.status();
  light_field::View& view = manifest_.views[number];
  view.file = wire::sha256_hex((*file)->bytes());
  view.file_bytes = (*file)->bytes().size();
  view.tiles = *std::move(tiles);
  if (manifest_.compression == light_field::Compression::kDwaa) {
    if (absl::Status s = measure_loss(path, *image); !s.ok()) return s;
  }
  std::error_code error;
  fs::rename(path, light_field::data_file(folder_, view), error);
  if (error) return absl::InternalError(absl::StrCat(path, ": ", error.message()));
  return absl::OkStatus();
}

absl::Status SetWriter::measure_loss(const std::string& path, const Image& written) {
  const absl::StatusOr<Image> read = read_exr(path);
  if (!read.ok()) return read.status();
  for (const char* const name : kColours) {
    const Channel* const before = written.find(name);
    const Channel* const after = read->find(name);
    if (before == nullptr || after == nullptr)
      return absl::InternalError(absl::StrCat(path, ": it has no channel ", name));
    for (std::size_t i = 0; i < before->values.size(); ++i) {
      const double difference = int{srgb_byte(before->values[i])} - int{srgb_byte(after->values[i])};
      squared_error_ += difference * difference;
    }
    codes_ += before->values.size();
  }
  return absl::OkStatus();
}

absl::Status SetWriter::finish() {
  if (codes_ > 0 && squared_error_ > 0)
    manifest_.psnr_db = 10 * std::log10(255.0 * 255.0 * static_cast<double>(codes_) / squared_error_);
  return replace_file_with((fs::path(folder_) / light_field::kManifestFile).string(),
                           light_field::to_json(manifest_));
}

}  // namespace tessera::client

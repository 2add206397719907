#include <algorithm>
#include <deque>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/color_space.h"
#include "image/exr.h"
#include "image/exr/channel_names.h"
#include "image/exr/chunk_writer.h"
#include "image/exr/exr_file.h"
#include "image/exr/level_writer.h"
#include "image/exr/part.h"
#include "image/exr/rows.h"

namespace tessera::client {
namespace {

absl::Status check(const Image& image) {
  for (const Window& window : {image.data, image.display}) {
    if (window.x1 <= window.x0 || window.y1 <= window.y0)
      return absl::InvalidArgumentError("the image is empty");
  }
  return image.channels.empty() ? absl::InvalidArgumentError("the image has no channels") : absl::OkStatus();
}

exr_attr_box2i_t box_of(const Window& window) {
  return {{window.x0, window.y0}, {window.x1 - 1, window.y1 - 1}};
}

/// Sets an attribute of a part by the kind of its value.
struct AttributeSetter {
  exr_context_t context;
  int part;
  const char* name;

  exr_result_t operator()(const std::string& text) const {
    return exr_attr_set_string(context, part, name, text.c_str());
  }
  exr_result_t operator()(std::int32_t number) const { return exr_attr_set_int(context, part, name, number); }
  exr_result_t operator()(float real) const { return exr_attr_set_float(context, part, name, real); }
  exr_result_t operator()(const Rational& ratio) const {
    const exr_attr_rational_t value = {ratio.numerator, ratio.denominator};
    return exr_attr_set_rational(context, part, name, &value);
  }
  exr_result_t operator()(const TimeCode& code) const {
    const exr_attr_timecode_t value = {code.time_and_flags, code.user_data};
    return exr_attr_set_timecode(context, part, name, &value);
  }
  exr_result_t operator()(const RowMatrix& matrix) const {
    exr_attr_m44f_t value;
    std::ranges::copy(matrix.m, value.m);
    return exr_attr_set_m44f(context, part, name, &value);
  }
  exr_result_t operator()(const Chromaticities& primaries) const {
    const std::array<float, 8>& xy = primaries.xy;
    const exr_attr_chromaticities_t value = {xy[0], xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]};
    return exr_attr_set_chromaticities(context, part, name, &value);
  }
  exr_result_t operator()(const NumberPair& pair) const {
    const exr_attr_v2f_t value = {pair.x, pair.y};
    return exr_attr_set_v2f(context, part, name, &value);
  }
};

void write_header(const ExrFile& file, const Image& image, const ExrPart& part, const ExrFormat& format) {
  const exr_context_t context = file.context();
  int index = 0;
  file.check(exr_add_part(context, part.name.empty() ? nullptr : part.name.c_str(),
                          format.tile_size > 0 ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &index));
  const exr_attr_box2i_t display = box_of(image.display), data = box_of(image.data);
  const exr_attr_v2f_t center = {0, 0};
  const exr_lineorder_t order = format.tile_size > 0 ? EXR_LINEORDER_RANDOM_Y : EXR_LINEORDER_INCREASING_Y;
  file.check(exr_initialize_required_attr(context, index, &display, &data, 1, &center, 1, order,
                                          compression_of(part.compression)));
  if (format.tile_size > 0) {
    file.check(exr_set_tile_descriptor(context, index, format.tile_size, format.tile_size,
                                       format.mipmaps ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL,
                                       EXR_TILE_ROUND_DOWN));
  }
  // Rec.709 is what a file without this attribute is taken for; saying so costs nothing.
  if (!image.metadata.contains(kChromaticities) && !image.metadata.contains(kRawChannels)) {
    const exr_attr_chromaticities_t rec709 = {.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f};
    file.check(exr_attr_set_chromaticities(context, index, kChromaticities, &rec709));
  }
  for (const PartChannel& channel : part.channels) {
    file.check(exr_add_channel(context, index, channel.name.c_str(),
                               channel.half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC,
                               1, 1));
  }
  // Attributes of a file that was read may say how that one is laid out.
  static const std::set<std::string> own = {"chunkCount", "name", "type", "version"};
  for (const auto& [key, value] : image.metadata) {
    if (own.contains(key)) continue;
    const AttributeSetter set{context, index, key.c_str()};
    // A Cryptomatte is called as its channels are.
    const bool names_layer = key.starts_with("cryptomatte/") && key.ends_with("/name");
    file.check(names_layer ? set(std::string(
                                 layer_of(channel_name(std::get<std::string>(value) + ".R", format.names))))
                           : std::visit(set, value));
  }
  for (const auto& [key, text] : format.attributes)
    file.check(exr_attr_set_string(context, index, key.c_str(), text.c_str()));
}

void write_pixels(const ExrFile& file, int index, const Image& image, Rows& rows, const ExrPart& part,
                  const ExrFormat& format) {
  const std::int32_t width = image.data.width(), height = image.data.height();
  ChunkWriter chunks(file, index, part);
  LevelWriter levels(chunks, part, width, height, static_cast<std::int32_t>(format.tile_size),
                     format.mipmaps);
  const std::int32_t lines = lines_of_chunk(part.compression);
  std::vector<std::vector<float>> row(part.channels.size(),
                                      std::vector<float>(static_cast<std::size_t>(width)));
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (const absl::Status status = rows.read(part.channels[c].plane, y, row[c]); !status.ok())
        throw WriteError(std::string(status.message()));
    }
    if (format.tile_size > 0) {
      levels.add(row);
      continue;
    }
    for (std::size_t c = 0; c < row.size(); ++c) chunks.append(row[c], part.channels[c].half);
    if ((y + 1) % lines == 0 || y + 1 == height) chunks.write_lines(image.data.y0 + y / lines * lines);
  }
}

/// A picture of a file, and what it becomes there.
struct Picture {
  const Image& image;
  Rows& rows;
  std::vector<ExrPart> parts;
};

bool has_long_names(const Picture& picture) {
  constexpr std::size_t kShortName = 31;
  const auto is_long = [](const std::string& name) { return name.size() > kShortName; };
  const auto has_long = [&](const ExrPart& part) {
    return std::ranges::any_of(part.channels, is_long, &PartChannel::name);
  };
  return std::ranges::any_of(picture.parts, has_long) ||
         std::ranges::any_of(picture.image.metadata, [&](const auto& entry) { return is_long(entry.first); });
}

void write_file(const std::vector<Picture>& pictures, const std::string& path, const ExrFormat& format) {
  ExrFile file(path);
  file.check(exr_set_longname_support(file.context(), std::ranges::any_of(pictures, has_long_names) ? 1 : 0));
  for (const Picture& picture : pictures) {
    for (const ExrPart& part : picture.parts) write_header(file, picture.image, part, format);
  }
  file.check(exr_write_header(file.context()));
  int index = 0;
  for (const Picture& picture : pictures) {
    for (const ExrPart& part : picture.parts)
      write_pixels(file, index++, picture.image, picture.rows, part, format);
  }
  file.finish();
}

/// InvalidArgument with the file's name.
absl::StatusOr<Picture> picture_of(const Image& image, Rows& rows, const std::string& path,
                                   const ExrFormat& format) {
  const absl::Status sound = check(image);
  absl::StatusOr<std::vector<ExrPart>> parts =
      sound.ok() ? parts_of(image, format) : absl::StatusOr<std::vector<ExrPart>>(sound);
  if (!parts.ok()) return absl::InvalidArgumentError(absl::StrCat(path, ": ", parts.status().message()));
  return Picture{image, rows, *std::move(parts)};
}

absl::Status write_pictures(const std::vector<Picture>& pictures, const std::string& path,
                            const ExrFormat& format) {
  return replace_file(path, [&](const std::string& file) {
    try {
      write_file(pictures, file, format);
      return absl::OkStatus();
    } catch (const std::exception& error) {
      return absl::InternalError(absl::StrCat(path, ": cannot write: ", error.what()));
    }
  });
}

absl::Status check_planes(const Image& image, const std::string& path) {
  for (const Channel& channel : image.channels) {
    if (channel.values.size() != image.pixel_count()) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": channel ", channel.name, " has the wrong size"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status write_exr(const Image& image, Rows& rows, const std::string& path, const ExrFormat& format) {
  absl::StatusOr<Picture> picture = picture_of(image, rows, path, format);
  if (!picture.ok()) return picture.status();
  return write_pictures({*std::move(picture)}, path, format);
}

absl::Status write_exr(const Image& image, const std::string& path, const ExrFormat& format) {
  if (absl::Status status = check_planes(image, path); !status.ok()) return status;
  ImageRows rows(image);
  return write_exr(image, rows, path, format);
}

absl::Status write_exr_views(std::span<const ExrView> views, const std::string& path,
                             const ExrFormat& format) {
  std::deque<ImageRows> own_rows;
  std::vector<Picture> pictures;
  std::set<std::string> names;
  for (const ExrView& view : views) {
    const auto found = view.image->metadata.find("view");
    const auto* const name =
        found == view.image->metadata.end() ? nullptr : std::get_if<std::string>(&found->second);
    if (name == nullptr || name->empty() || !names.insert(*name).second)
      return absl::InvalidArgumentError(absl::StrCat(path, ": views of one file have names that differ"));
    if (view.rows == nullptr) {
      if (absl::Status status = check_planes(*view.image, path); !status.ok()) return status;
    }
    Rows& rows = view.rows != nullptr ? *view.rows : own_rows.emplace_back(*view.image);
    absl::StatusOr<Picture> picture = picture_of(*view.image, rows, path, format);
    if (!picture.ok()) return picture.status();
    for (ExrPart& part : picture->parts)
      part.name = absl::StrCat(part.name.empty() ? "rgba" : part.name, ".", *name);
    pictures.push_back(*std::move(picture));
  }
  return write_pictures(pictures, path, format);
}

}  // namespace tessera::client

#include <Imath/half.h>
#include <OpenEXR/openexr.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <span>
#include <stdexcept>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/exr.h"
#include "image/zip_block.h"

namespace tessera::client {
namespace {

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

std::vector<Imath::half> to_half(std::span<const float> values) {
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

/// Those of each part, by its name; in the order of the file, which is that of their names.
std::map<std::string, Channels> parts_of(const Image& image, ExrParts parts) {
  std::map<std::string, Channels> result;
  for (const Channel& channel : image.channels)
    result[parts == ExrParts::kMany ? layer_of(channel) : ""].push_back(&channel);
  for (auto& [name, channels] : result) std::ranges::sort(channels, {}, &Channel::name);
  return result;
}

/// Ends the writing of a file: the library has refused something.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file that OpenEXRCore writes. Its C++ interface has no place for a deflate of one's own.
class ExrFile {
 public:
  explicit ExrFile(const std::string& path)
      : descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) throw WriteError(std::strerror(errno));
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = this;
    how.write_fn = &ExrFile::write;
    how.error_handler_fn = &ExrFile::note_error;
    check(exr_start_write(&context_, path.c_str(), EXR_WRITE_FILE_DIRECTLY, &how));
  }
  ~ExrFile() {
    if (context_ != nullptr) static_cast<void>(exr_finish(&context_));
    ::close(descriptor_);
  }
  ExrFile(const ExrFile&) = delete;
  ExrFile& operator=(const ExrFile&) = delete;

  exr_context_t context() const { return context_; }
  void check(exr_result_t result) const {
    if (result != EXR_ERR_SUCCESS)
      throw WriteError(error_.empty() ? exr_get_default_error_message(result) : error_);
  }
  /// Writes the places of all chunks.
  void finish() { check(exr_finish(&context_)); }

 private:
  static std::int64_t write(exr_const_context_t, void* self, const void* bytes, std::uint64_t size,
                            std::uint64_t offset, exr_stream_error_func_ptr_t) {
    ExrFile& file = *static_cast<ExrFile*>(self);
    for (std::uint64_t done = 0; done < size;) {
      const ssize_t written = ::pwrite(file.descriptor_, static_cast<const char*>(bytes) + done, size - done,
                                       static_cast<off_t>(offset + done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        file.error_ = std::strerror(written < 0 ? errno : ENOSPC);
        return -1;
      }
      done += static_cast<std::uint64_t>(written);
    }
    return static_cast<std::int64_t>(size);
  }
  static void note_error(exr_const_context_t context, exr_result_t, const char* message) {
    void* self = nullptr;
    if (context == nullptr || exr_get_user_data(context, &self) != EXR_ERR_SUCCESS || self == nullptr) return;
    std::string& error = static_cast<ExrFile*>(self)->error_;
    if (error.empty()) error = message;  // the first one is the cause
  }

  const int descriptor_;
  exr_context_t context_ = nullptr;
  std::string error_;
};

exr_attr_box2i_t box_of(const Window& window) {
  return {{window.x0, window.y0}, {window.x1 - 1, window.y1 - 1}};
}

void write_header(const ExrFile& file, const Image& image, const std::string& name, const Channels& channels,
                  PixelType type) {
  const exr_context_t context = file.context();
  int part = 0;
  file.check(exr_add_part(context, name.empty() ? nullptr : name.c_str(), EXR_STORAGE_SCANLINE, &part));
  const exr_attr_box2i_t display = box_of(image.display), data = box_of(image.data);
  const exr_attr_v2f_t center = {0, 0};
  file.check(exr_initialize_required_attr(context, part, &display, &data, 1, &center, 1,
                                          EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP));
  // Rec.709 is what a file without this attribute is taken for; saying so costs nothing.
  const exr_attr_chromaticities_t rec709 = {.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f};
  file.check(exr_attr_set_chromaticities(context, part, "chromaticities", &rec709));
  for (const Channel* const channel : channels) {
    const bool half = stored_as_half(channel->name, type);
    file.check(exr_add_channel(context, part, channel->name.c_str(), half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  }
  // Attributes of a file that was read may say how that one is laid out.
  static const std::set<std::string> own = {"chunkCount", "name", "type", "version"};
  for (const auto& [key, value] : image.metadata) {
    if (own.contains(key)) continue;
    if (const auto* text = std::get_if<std::string>(&value))
      file.check(exr_attr_set_string(context, part, key.c_str(), text->c_str()));
    if (const auto* number = std::get_if<std::int32_t>(&value))
      file.check(exr_attr_set_int(context, part, key.c_str(), *number));
    if (const auto* real = std::get_if<float>(&value))
      file.check(exr_attr_set_float(context, part, key.c_str(), *real));
  }
}

/// A block of so many scanlines is compressed as one: that of ZIP files.
constexpr std::int32_t kBlockLines = 16;

/// Appends the row of a channel, little endian.
void append_row(std::span<const float> row, bool half, std::vector<unsigned char>& block) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t at = block.size();
  if (half) {
    const std::vector<Imath::half> halves = to_half(row);
    block.resize(at + halves.size() * sizeof(Imath::half));
    std::memcpy(block.data() + at, halves.data(), halves.size() * sizeof(Imath::half));
  } else {
    block.resize(at + row.size_bytes());
    std::memcpy(block.data() + at, row.data(), row.size_bytes());
  }
}

void write_pixels(const ExrFile& file, int part, const Image& image, const Channels& channels,
                  PixelType type) {
  const auto width = static_cast<std::size_t>(image.data.width());
  ZipBlockPacker packer;
  std::vector<unsigned char> block;
  for (std::int32_t y = 0; y < image.data.height(); y += kBlockLines) {
    block.clear();
    for (std::int32_t line = y; line < std::min(y + kBlockLines, image.data.height()); ++line) {
      for (const Channel* const channel : channels) {
        const std::span<const float> plane = channel->values;
        append_row(plane.subspan(static_cast<std::size_t>(line) * width, width),
                   stored_as_half(channel->name, type), block);
      }
    }
    const std::span<const unsigned char> packed = packer.pack(block);
    file.check(
        exr_write_scanline_chunk(file.context(), part, image.data.y0 + y, packed.data(), packed.size()));
  }
}

void write_file(const Image& image, const std::string& path, PixelType type, ExrParts wanted) {
  const std::map<std::string, Channels> parts = parts_of(image, wanted);
  ExrFile file(path);
  constexpr std::size_t kShortName = 31;
  const auto is_long = [](const std::string& name) { return name.size() > kShortName; };
  const bool long_names =
      std::ranges::any_of(image.channels, is_long, &Channel::name) ||
      std::ranges::any_of(image.metadata, [&](const auto& entry) { return is_long(entry.first); });
  file.check(exr_set_longname_support(file.context(), long_names));
  for (const auto& [name, channels] : parts)
    write_header(file, image, parts.size() > 1 && name.empty() ? "rgba" : name, channels, type);
  file.check(exr_write_header(file.context()));
  int part = 0;
  for (const auto& [name, channels] : parts) write_pixels(file, part++, image, channels, type);
  file.finish();
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

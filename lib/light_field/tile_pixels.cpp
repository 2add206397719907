#include "light_field/tile_pixels.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>

#include "absl/strings/str_cat.h"
#include "images/memory_stream.h"

namespace tessera::light_field {
namespace {

constexpr std::array<const char*, 5> kChannels = {"A", "B", "G", "R", "depth.Z"};
/// Places in a pixel of red, green, blue and alpha, in the order of the file's channels.
constexpr std::array<std::size_t, 4> kPlaces = {3, 2, 1, 0};

void ignore_message(exr_const_context_t, exr_result_t, const char*) {}

bool has_channels(exr_const_context_t context) {
  const exr_attr_chlist_t* list = nullptr;
  if (exr_get_channels(context, 0, &list) != EXR_ERR_SUCCESS || list == nullptr) return false;
  if (list->num_channels != static_cast<int>(kChannels.size())) return false;
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const exr_attr_chlist_entry_t& entry = list->entries[c];
    if (std::strcmp(entry.name.str, kChannels[c]) != 0 || entry.pixel_type == EXR_PIXEL_UINT) return false;
  }
  return true;
}

/// A decoding pipeline that goes away again.
class Decoding {
 public:
  explicit Decoding(exr_const_context_t context) : context_(context) {}
  ~Decoding() {
    if (begun_) static_cast<void>(exr_decoding_destroy(context_, &pipeline_));
  }
  Decoding(const Decoding&) = delete;
  Decoding& operator=(const Decoding&) = delete;

  bool run(const exr_chunk_info_t& chunk, const TileTarget& target) {
    if (exr_decoding_initialize(context_, 0, &chunk, &pipeline_) != EXR_ERR_SUCCESS) return false;
    begun_ = true;
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      exr_coding_channel_info_t& channel = pipeline_.channels[c];
      const bool is_colour = c < kPlaces.size();
      float* const to = is_colour ? target.rgba + kPlaces[c] : target.distance;
      const std::size_t stride = sizeof(float) * (is_colour ? 4 : 1);
      channel.decode_to_ptr = reinterpret_cast<std::uint8_t*>(to);
      channel.user_bytes_per_element = sizeof(float);
      channel.user_data_type = EXR_PIXEL_FLOAT;
      channel.user_pixel_stride = static_cast<std::int32_t>(stride);
      channel.user_line_stride = static_cast<std::int32_t>(stride * target.row_pixels);
    }
    return exr_decoding_choose_default_routines(context_, 0, &pipeline_) == EXR_ERR_SUCCESS &&
           exr_decoding_run(context_, 0, &pipeline_) == EXR_ERR_SUCCESS;
  }

 private:
  const exr_const_context_t context_;
  exr_decode_pipeline_t pipeline_ = EXR_DECODE_PIPELINE_INITIALIZER;
  bool begun_ = false;
};

}  // namespace

TileFileReader::TileFileReader(std::string path, const char* bytes, std::size_t size)
    : path_(std::move(path)), bytes_(bytes), size_(size) {}

TileFileReader::~TileFileReader() {
  if (context_ != nullptr) static_cast<void>(exr_finish(&context_));
  if (size_ > 0) ::munmap(const_cast<char*>(bytes_), size_);
}

absl::Status TileFileReader::broken(const std::string& what) const {
  return absl::InvalidArgumentError(absl::StrCat(path_, ": ", what));
}

std::int64_t TileFileReader::read_bytes(exr_const_context_t, void* self, void* to, std::uint64_t size,
                                        std::uint64_t offset, exr_stream_error_func_ptr_t) {
  const TileFileReader& file = *static_cast<const TileFileReader*>(self);
  if (offset > file.size_) return -1;
  // Headers are read ahead: at the end of a file, there is less, as of pread().
  const std::uint64_t there = std::min<std::uint64_t>(size, file.size_ - offset);
  std::memcpy(to, file.bytes_ + offset, there);
  return static_cast<std::int64_t>(there);
}

std::int64_t TileFileReader::size_of(exr_const_context_t, void* self) {
  return static_cast<std::int64_t>(static_cast<const TileFileReader*>(self)->size_);
}

absl::StatusOr<std::unique_ptr<TileFileReader>> TileFileReader::open(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return absl::NotFoundError(absl::StrCat(path, ": ", std::strerror(errno)));
  struct stat facts {};
  void* bytes = MAP_FAILED;
  if (::fstat(descriptor, &facts) == 0 && facts.st_size > 0)
    bytes = ::mmap(nullptr, static_cast<std::size_t>(facts.st_size), PROT_READ, MAP_SHARED, descriptor, 0);
  ::close(descriptor);
  if (bytes == MAP_FAILED) return absl::InvalidArgumentError(absl::StrCat(path, ": it cannot be read"));
  std::unique_ptr<TileFileReader> file(
      new TileFileReader(path, static_cast<const char*>(bytes), static_cast<std::size_t>(facts.st_size)));
  if (absl::Status s = file->read_header(); !s.ok()) return s;
  return file;
}

absl::Status TileFileReader::read_header() {
  exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
  how.user_data = this;
  how.read_fn = &TileFileReader::read_bytes;
  how.size_fn = &TileFileReader::size_of;
  how.error_handler_fn = &ignore_message;
  if (exr_start_read(&context_, path_.c_str(), &how) != EXR_ERR_SUCCESS)
    return broken("it is no sound OpenEXR file");
  exr_storage_t storage = EXR_STORAGE_SCANLINE;
  exr_attr_box2i_t window{};
  std::uint32_t tile_x = 0, tile_y = 0;
  exr_tile_level_mode_t levels = EXR_TILE_ONE_LEVEL;
  exr_tile_round_mode_t rounding = EXR_TILE_ROUND_DOWN;
  const bool is_tiled =
      exr_get_storage(context_, 0, &storage) == EXR_ERR_SUCCESS && storage == EXR_STORAGE_TILED &&
      exr_get_tile_descriptor(context_, 0, &tile_x, &tile_y, &levels, &rounding) == EXR_ERR_SUCCESS &&
      exr_get_data_window(context_, 0, &window) == EXR_ERR_SUCCESS;
  if (!is_tiled || tile_x != tile_y || tile_x == 0 || levels != EXR_TILE_ONE_LEVEL ||
      !has_channels(context_) || window.min.x != 0 || window.min.y != 0) {
    return broken("it has no tiles of A, B, G, R and depth.Z from (0, 0) on");
  }
  exr_compression_t compression = EXR_COMPRESSION_NONE;
  if (exr_get_compression(context_, 0, &compression) != EXR_ERR_SUCCESS)
    return broken("its compression is unknown");
  lossy_ = compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
  width_ = static_cast<std::uint32_t>(window.max.x) + 1;
  height_ = static_cast<std::uint32_t>(window.max.y) + 1;
  tile_size_ = tile_x;
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Tile>> TileFileReader::tiles() const {
  std::vector<Tile> tiles;
  for (std::uint32_t y = 0; y * tile_size_ < height_; ++y) {
    for (std::uint32_t x = 0; x * tile_size_ < width_; ++x) {
      exr_chunk_info_t chunk;
      const exr_result_t found =
          exr_read_tile_chunk_info(context_, 0, static_cast<int>(x), static_cast<int>(y), 0, 0, &chunk);
      if (found != EXR_ERR_SUCCESS || chunk.data_offset > size_ ||
          chunk.packed_size > size_ - chunk.data_offset) {
        return broken(absl::StrCat("tile ", x, ",", y, " is not where its table says"));
      }
      tiles.push_back({chunk.data_offset, chunk.packed_size,
                       tile_hash(bytes().substr(chunk.data_offset, chunk.packed_size))});
    }
  }
  return tiles;
}

bool TileFileReader::read_lossy(std::uint32_t column, std::uint32_t row, const TileTarget& target) const {
  try {
    images::MemoryStream stream(bytes());
    Imf::TiledInputFile file(stream, 0);
    // The library addresses pixels by their coordinates in the picture.
    const std::size_t first = (std::size_t{row} * target.row_pixels + column) * tile_size_;
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      const bool is_colour = c < kPlaces.size();
      const std::size_t stride = is_colour ? 4 : 1;
      float* const to = (is_colour ? target.rgba + kPlaces[c] : target.distance) - first * stride;
      frame.insert(kChannels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(to), sizeof(float) * stride,
                                            sizeof(float) * stride * target.row_pixels));
    }
    file.setFrameBuffer(frame);
    file.readTile(static_cast<int>(column), static_cast<int>(row));
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

absl::Status TileFileReader::read(std::uint32_t column, std::uint32_t row, const TileTarget& target) const {
  if (lossy_) {
    if (read_lossy(column, row, target)) return absl::OkStatus();
    return broken(absl::StrCat("tile ", column, ",", row, " cannot be decoded"));
  }
  exr_chunk_info_t chunk;
  Decoding decoding(context_);
  if (exr_read_tile_chunk_info(context_, 0, static_cast<int>(column), static_cast<int>(row), 0, 0, &chunk) !=
          EXR_ERR_SUCCESS ||
      !decoding.run(chunk, target)) {
    return broken(absl::StrCat("tile ", column, ",", row, " cannot be decoded"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::light_field

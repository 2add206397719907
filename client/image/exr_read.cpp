#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTimeCodeAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <span>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "image/color_space.h"
#include "image/exr.h"

namespace tessera::client {
namespace {

// Uncompressed bytes that a file may claim for free, and how many more for each byte that it has. Deflate
// reaches 1032, and only images of one colour more.
constexpr std::uint64_t kFreeBytes = std::uint64_t{512} << 20;
constexpr std::uint64_t kMaxExpansion = 2000;
// Decoding happens on the calling thread: handing small images to other threads costs more than it saves.
constexpr int kNoThreads = 0;

absl::Status broken(const std::string& path, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

// In 64 bits, for the differences of a broken file may not fit 32.
absl::Status check_window(const Imath::Box2i& box, std::uint64_t max_pixels, const std::string& path) {
  const std::int64_t width = std::int64_t{box.max.x} - box.min.x + 1;
  const std::int64_t height = std::int64_t{box.max.y} - box.min.y + 1;
  constexpr std::int64_t kMaxSide = std::int64_t{1} << 24;
  if (width <= 0 || height <= 0) return broken(path, "empty data or display window");
  if (width > kMaxSide || height > kMaxSide || std::uint64_t(width) * std::uint64_t(height) > max_pixels) {
    return broken(path, absl::StrCat("claims ", width, " x ", height,
                                     " pixels, which is more than the limit of ", max_pixels));
  }
  return absl::OkStatus();
}

/// `channels`: that the parts before this one have.
absl::Status check_header(const Imf::Header& header, std::uint64_t max_pixels, std::uint64_t channels,
                          const std::string& path) {
  if (header.hasType() && Imf::isDeepData(header.type()))
    return broken(path, "deep images are not supported");
  absl::Status status = check_window(header.dataWindow(), max_pixels, path);
  // The display window is not stored pixel by pixel; only its sides must make sense.
  if (status.ok())
    status = check_window(header.displayWindow(), std::numeric_limits<std::uint64_t>::max(), path);
  if (!status.ok()) return status;

  const Imath::Box2i& box = header.dataWindow();
  const std::uint64_t pixels =
      std::uint64_t(box.max.x - box.min.x + 1) * std::uint64_t(box.max.y - box.min.y + 1);
  const std::uint64_t before = channels;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) ++channels;
  if (channels == before) return broken(path, "no channels");
  std::error_code error;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  if (error) return broken(path, error.message());
  if (pixels * channels * sizeof(float) > kFreeBytes + kMaxExpansion * file_bytes) {
    return broken(path, absl::StrCat("claims ", channels, " channels of ", pixels, " pixels in ", file_bytes,
                                     " bytes: truncated or broken"));
  }
  return absl::OkStatus();
}

Window window_of(const Imath::Box2i& box) { return {box.min.x, box.min.y, box.max.x + 1, box.max.y + 1}; }

void read_metadata(const Imf::Header& header, Image& image) {
  for (auto it = header.begin(); it != header.end(); ++it) {
    const Imf::Attribute& attribute = it.attribute();
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
      image.metadata[it.name()] = text->value();
    } else if (const auto* number = dynamic_cast<const Imf::IntAttribute*>(&attribute)) {
      image.metadata[it.name()] = std::int32_t{number->value()};
    } else if (const auto* real = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
      image.metadata[it.name()] = real->value();
    } else if (const auto* ratio = dynamic_cast<const Imf::RationalAttribute*>(&attribute)) {
      image.metadata[it.name()] = Rational{ratio->value().n, ratio->value().d};
    } else if (const auto* code = dynamic_cast<const Imf::TimeCodeAttribute*>(&attribute)) {
      image.metadata[it.name()] = TimeCode{code->value().timeAndFlags(), code->value().userData()};
    } else if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&attribute)) {
      RowMatrix& copy = std::get<RowMatrix>(image.metadata[it.name()] = RowMatrix{});
      std::copy_n(matrix->value().getValue(), copy.m.size(), copy.m.begin());
    } else if (const auto* primaries = dynamic_cast<const Imf::ChromaticitiesAttribute*>(&attribute)) {
      const Imf::Chromaticities& c = primaries->value();
      const auto at = [](const Imath::V2f& xy) { return spectra::Chromaticity{xy.x, xy.y}; };
      if (std::string_view(it.name()) == kChromaticities)
        set_space({at(c.red), at(c.green), at(c.blue), at(c.white)}, image);
    } else if (const auto* pair = dynamic_cast<const Imf::V2fAttribute*>(&attribute)) {
      // A required attribute, which each file gets when it is written.
      if (std::string_view(it.name()) != "screenWindowCenter")
        image.metadata[it.name()] = NumberPair{pair->value().x, pair->value().y};
    }
  }
}

bool is_subsampled(const Imf::ChannelList& channels) {
  for (auto it = channels.begin(); it != channels.end(); ++it) {
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) return true;
  }
  return false;
}

// Luminance/chroma files: OpenEXR's own conversion to RGBA.
void read_subsampled(const std::string& path, Image& image) {
  Imf::RgbaInputFile input(path.c_str(), kNoThreads);
  const Imath::Box2i box = input.dataWindow();
  Imf::Array2D<Imf::Rgba> pixels(image.data.height(), image.data.width());
  const std::ptrdiff_t origin = box.min.x + std::ptrdiff_t{box.min.y} * image.data.width();
  input.setFrameBuffer(&pixels[0][0] - origin, 1, image.data.width());
  input.readPixels(box.min.y, box.max.y);
  const Imf::Rgba* source = &pixels[0][0];
  constexpr Imath::half Imf::Rgba::*kMembers[] = {&Imf::Rgba::r, &Imf::Rgba::g, &Imf::Rgba::b, &Imf::Rgba::a};
  constexpr const char* kNames[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 4; ++c) {
    Channel& channel = image.add(kNames[c]);
    for (std::size_t i = 0; i < image.pixel_count(); ++i) channel.values[i] = source[i].*kMembers[c];
  }
}

/// Adds the channels of a part, but for those whose names the image has already.
void read_planes(Imf::MultiPartInputFile& file, int part, Image& image) {
  Imf::InputPart input(file, part);
  const Imf::Header& header = input.header();
  const Imath::Box2i box = header.dataWindow();
  const std::size_t first = image.channels.size();
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (image.find(it.name()) == nullptr) image.add(it.name());
  }
  if (image.channels.size() == first) return;
  // OpenEXR converts half and integer pixels to the slice's type.
  Imf::FrameBuffer frame;
  for (Channel& channel : std::span(image.channels).subspan(first)) {
    frame.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, channel.values.data(), box));
  }
  input.setFrameBuffer(frame);
  input.readPixels(box.min.y, box.max.y);
}

/// The view that a part is of; empty: none.
std::string view_of(const Imf::Header& header) { return header.hasView() ? header.view() : std::string(); }

/// Whether a further part is of the same pixels and view, and flat.
bool belongs(const Imf::Header& header, const Imf::Header& first, const Image& image) {
  const bool deep = header.hasType() && Imf::isDeepData(header.type());
  return !deep && view_of(header) == view_of(first) && window_of(header.dataWindow()) == image.data &&
         !is_subsampled(header.channels());
}

/// The first part of a view, 0 where none is asked for.
absl::StatusOr<int> first_part(const Imf::MultiPartInputFile& file, const std::string& path,
                               const std::string& view) {
  if (view.empty()) return 0;
  std::vector<std::string> names;
  for (int part = 0; part < file.parts(); ++part) {
    const std::string own = view_of(file.header(part));
    if (own == view) return part;
    if (!own.empty() && std::ranges::find(names, own) == names.end()) names.push_back(own);
  }
  if (names.empty())
    return broken(path, absl::StrCat("has no view '", view, "', as its pictures have no names"));
  return broken(path, absl::StrCat("has no view '", view, "'; its views are ", absl::StrJoin(names, ", ")));
}

Image facts_of(const Imf::Header& header) {
  Image image;
  image.data = window_of(header.dataWindow());
  image.display = window_of(header.displayWindow());
  read_metadata(header, image);
  return image;
}

absl::StatusOr<Image> read_file(const std::string& path, std::size_t max_pixels, const std::string& view) {
  Imf::MultiPartInputFile file(path.c_str(), kNoThreads);
  const absl::StatusOr<int> first = first_part(file, path, view);
  if (!first.ok()) return first.status();
  const Imf::Header& header = file.header(*first);
  if (absl::Status status = check_header(header, max_pixels, 0, path); !status.ok()) return status;
  Image image = facts_of(header);
  if (is_subsampled(header.channels())) {
    if (*first > 0) return broken(path, "only the first of its parts may have channels of less resolution");
    read_subsampled(path, image);
  } else {
    read_planes(file, *first, image);
    for (int part = *first + 1; part < file.parts(); ++part) {
      if (!belongs(file.header(part), header, image)) continue;
      if (absl::Status status = check_header(file.header(part), max_pixels, image.channels.size(), path);
          !status.ok())
        return status;
      read_planes(file, part, image);
    }
  }
  return image;
}

template <class Read>
absl::StatusOr<Image> read_safely(const std::string& path, Read&& read) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return absl::NotFoundError(absl::StrCat(path, ": no such file"));
  if (!std::filesystem::is_regular_file(path, error)) return broken(path, "not a regular file");
  try {
    return read();
  } catch (const std::exception& exception) {
    return broken(path, absl::StrCat("cannot read as OpenEXR: ", exception.what()));
  }
}

}  // namespace

absl::StatusOr<Image> read_exr(const std::string& path, std::size_t max_pixels, const std::string& view) {
  return read_safely(path, [&] { return read_file(path, max_pixels, view); });
}

absl::StatusOr<Image> read_exr_facts(const std::string& path) {
  return read_safely(path, [&]() -> absl::StatusOr<Image> {
    const Imf::MultiPartInputFile file(path.c_str(), kNoThreads);
    return facts_of(file.header(0));
  });
}

}  // namespace tessera::client

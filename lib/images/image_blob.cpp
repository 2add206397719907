#include "images/image_blob.h"

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "base/installed_module.h"
#include "images/module.h"
#include "images/readers.h"

namespace tessera::images {
namespace {

absl::Status invalid(const std::string& name, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("image ", name, ": ", what));
}

struct Format {
  const char* name;              // OpenImageIO's
  ImageReader reader = nullptr;  // reads its plain forms; null: OpenImageIO reads all
};

/// Null when it is none that we read.
const Format* detect_format(std::string_view bytes, const std::string& name) {
  static constexpr Format kPng{"png", read_png}, kJpeg{"jpeg", read_jpeg}, kExr{"openexr", read_exr},
      kHdr{"hdr"}, kTiff{"tiff"}, kBmp{"bmp"}, kPfm{"pnm", read_pfm}, kPnm{"pnm"}, kTga{"targa", read_tga},
      kWebp{"webp"};
  const auto starts = [&](std::string_view mark) { return bytes.starts_with(mark); };
  if (starts("\x89PNG\r\n\x1a\n")) return &kPng;
  if (starts("\xff\xd8\xff")) return &kJpeg;
  if (starts("\x76\x2f\x31\x01")) return &kExr;
  if (starts("#?RADIANCE") || starts("#?RGBE")) return &kHdr;
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return &kTiff;
  if (starts("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return &kWebp;
  if (starts("BM")) return &kBmp;
  if (starts("PF") || starts("Pf")) return &kPfm;
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return &kPnm;
  if (absl::EndsWithIgnoreCase(name, ".tga")) return &kTga;
  return nullptr;
}

absl::StatusOr<const Format*> format_of(std::string_view blob, const std::string& name) {
  const Format* format = detect_format(blob, name);
  if (format != nullptr && format->reader == read_exr && !is_plausible_exr(blob)) {
    return invalid(name,
                   "an attribute of its header does not have its size or is longer than the file, its blocks "
                   "are of more "
                   "than 256 MB, or the header has no end");
  }
  if (format != nullptr) return format;
  return invalid(name, "it is none of PNG, JPEG, WebP, TGA, BMP, EXR, HDR, PFM, PNM and TIFF");
}

absl::StatusOr<const ImageModule*> open_module() {
  const auto entry = base::installed_module(kImageModuleFile, kImageModuleEntry, "images cannot be read");
  if (!entry.ok()) return entry.status();
  return reinterpret_cast<ImageModuleEntry>(*entry)();
}

/// Calls `work(module, message)`, and gives its fault the file's name.
template <class Work>
absl::Status with_module(const std::string& name, const Work& work) {
  static const absl::StatusOr<const ImageModule*> module = open_module();
  if (!module.ok()) return module.status();
  std::string message;
  switch (work(**module, message)) {
    case ImageFault::kNone:
      return absl::OkStatus();
    case ImageFault::kTooLarge:
      return absl::ResourceExhaustedError(absl::StrCat("image ", name, ": ", message));
    case ImageFault::kInvalid:
      break;
  }
  return invalid(name, message);
}

}  // namespace

absl::StatusOr<ImagePixels> decode_image(std::string_view blob, const std::string& name,
                                         std::uint64_t max_pixels) {
  const absl::StatusOr<const Format*> format = format_of(blob, name);
  if (!format.ok()) return format.status();
  ImagePixels pixels;
  if ((*format)->reader != nullptr && (*format)->reader(blob, max_pixels, pixels)) return pixels;
  pixels = {};
  const absl::Status status = with_module(name, [&](const ImageModule& module, std::string& message) {
    return module.decode(blob, (*format)->name, max_pixels, pixels, message);
  });
  if (!status.ok()) return status;
  return pixels;
}

absl::StatusOr<ImageSize> image_size(std::string_view blob, const std::string& name,
                                     std::uint64_t max_pixels) {
  const absl::StatusOr<const Format*> format = format_of(blob, name);
  if (!format.ok()) return format.status();
  ImagePixels header;  // whose pixels there is no room for
  if ((*format)->reader != nullptr) (*format)->reader(blob, 0, header);
  ImageSize size = header.size;
  if (size.width == 0) {
    const absl::Status status = with_module(name, [&](const ImageModule& module, std::string& message) {
      return module.size(blob, (*format)->name, size, message);
    });
    if (!status.ok()) return status;
  }
  if (static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height) <= max_pixels)
    return size;
  return absl::ResourceExhaustedError(absl::StrCat("image ", name, ": ", too_many_pixels(size, max_pixels)));
}

}  // namespace tessera::images

#include "wire/image_blob.h"

#include <dlfcn.h>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "wire/image_module.h"

namespace tessera::wire {
namespace {

absl::Status invalid(const std::string& name, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("image ", name, ": ", what));
}

/// OpenImageIO's name of the format, null when it is none that we read.
const char* detect_format(std::string_view bytes, const std::string& name) {
  const auto starts = [&](std::string_view mark) { return bytes.starts_with(mark); };
  if (starts("\x89PNG\r\n\x1a\n")) return "png";
  if (starts("\xff\xd8\xff")) return "jpeg";
  if (starts("\x76\x2f\x31\x01")) return "openexr";
  if (starts("#?RADIANCE") || starts("#?RGBE")) return "hdr";
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return "tiff";
  if (starts("BM")) return "bmp";
  if (starts("PF") || starts("Pf")) return "pnm";
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return "pnm";
  if (absl::EndsWithIgnoreCase(name, ".tga")) return "targa";
  return nullptr;
}

/// Found by the program's run path, as kernels are. Never closed: its libraries have threads of their own.
absl::StatusOr<const ImageModule*> open_module() {
  void* const module = dlopen(kImageModuleFile, RTLD_LAZY | RTLD_LOCAL);
  if (module == nullptr) return absl::FailedPreconditionError(absl::StrCat("images cannot be read: ", dlerror()));
  const auto entry = reinterpret_cast<ImageModuleEntry>(dlsym(module, kImageModuleEntry));
  if (entry == nullptr) return absl::FailedPreconditionError(absl::StrCat("images cannot be read: ", dlerror()));
  return entry();
}

/// Calls `work(module, format, message)`, and gives its fault the file's name.
template <class Work>
absl::Status with_module(std::string_view blob, const std::string& name, const Work& work) {
  const char* const format = detect_format(blob, name);
  if (format == nullptr) return invalid(name, "it is none of PNG, JPEG, TGA, BMP, EXR, HDR, PFM, PNM and TIFF");
  static const absl::StatusOr<const ImageModule*> module = open_module();
  if (!module.ok()) return module.status();
  std::string message;
  switch (work(**module, format, message)) {
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

absl::StatusOr<ImagePixels> decode_image(std::string_view blob, const std::string& name, std::uint64_t max_pixels) {
  ImagePixels pixels;
  const absl::Status status =
      with_module(blob, name, [&](const ImageModule& module, const char* format, std::string& message) {
        return module.decode(blob, format, max_pixels, pixels, message);
      });
  if (!status.ok()) return status;
  return pixels;
}

absl::StatusOr<ImageSize> image_size(std::string_view blob, const std::string& name) {
  ImageSize size;
  const absl::Status status =
      with_module(blob, name, [&](const ImageModule& module, const char* format, std::string& message) {
        return module.size(blob, format, size, message);
      });
  if (!status.ok()) return status;
  return size;
}

}  // namespace tessera::wire

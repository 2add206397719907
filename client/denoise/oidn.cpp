// Open Image Denoise is no package of every system: its C interface, which is the same in versions 1 and 2,
// is looked up when it is asked for.
#include <dlfcn.h>

#include <cstddef>
#include <memory>

#include "absl/strings/str_cat.h"
#include "denoise/methods.h"

namespace tessera::client::denoise {
namespace {

using Device = struct OidnDevice*;
using Filter = struct OidnFilter*;
constexpr int kDefaultDevice = 0, kFloat3 = 3;

struct Close {
  void operator()(void* library) const { dlclose(library); }
};
using Library = std::unique_ptr<void, Close>;

absl::StatusOr<Library> open(const std::string& named) {
  std::string reason;
  for (const char* const usual :
       {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so"}) {
    const std::string name = named.empty() ? usual : named;
    if (void* const library = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL); library != nullptr)
      return Library(library);
    if (const char* const error = dlerror(); reason.empty() && error != nullptr) reason = error;
  }
  return absl::NotFoundError(
      absl::StrCat("Open Image Denoise is not here (", reason,
                   "): install it, or name its library with $TESSERA_OIDN; 'statistical' and 'regression' "
                   "need nothing"));
}

struct Functions {
  Device (*new_device)(int) = nullptr;
  void (*commit_device)(Device) = nullptr;
  void (*release_device)(Device) = nullptr;
  int (*get_error)(Device, const char**) = nullptr;
  Filter (*new_filter)(Device, const char*) = nullptr;
  void (*set_image)(Filter, const char*, void*, int, std::size_t, std::size_t, std::size_t, std::size_t,
                    std::size_t) = nullptr;
  void (*set_bool)(Filter, const char*, bool) = nullptr;
  void (*commit_filter)(Filter) = nullptr;
  void (*execute)(Filter) = nullptr;
  void (*release_filter)(Filter) = nullptr;
};

template <class F>
bool look_up(void* library, const char* name, F*& function) {
  if (function == nullptr) function = reinterpret_cast<F*>(dlsym(library, name));
  return function != nullptr;
}

absl::StatusOr<Functions> functions_of(void* library) {
  Functions f;
  look_up(library, "oidnSetFilterBool", f.set_bool);  // version 2 alone has it
  const bool all = look_up(library, "oidnNewDevice", f.new_device) &&
                   look_up(library, "oidnCommitDevice", f.commit_device) &&
                   look_up(library, "oidnReleaseDevice", f.release_device) &&
                   look_up(library, "oidnGetDeviceError", f.get_error) &&
                   look_up(library, "oidnNewFilter", f.new_filter) &&
                   look_up(library, "oidnSetSharedFilterImage", f.set_image) &&
                   look_up(library, "oidnSetFilter1b", f.set_bool) &&
                   look_up(library, "oidnCommitFilter", f.commit_filter) &&
                   look_up(library, "oidnExecuteFilter", f.execute) &&
                   look_up(library, "oidnReleaseFilter", f.release_filter);
  if (!all) return absl::InternalError("the library is not Open Image Denoise 1 or 2");
  return f;
}

/// Three planes as one picture, row after row.
template <class Value>
std::vector<float> interleaved(const NoisyPicture& picture, Value&& value) {
  std::vector<float> pixels;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) pixels.push_back(value(c, x, y));
    }
  }
  return pixels;
}

}  // namespace

absl::StatusOr<Colours> denoise_by_oidn(const NoisyPicture& picture, const std::string& library_name) {
  const absl::StatusOr<Library> library = open(library_name);
  if (!library.ok()) return library.status();
  const absl::StatusOr<Functions> found = functions_of(library->get());
  if (!found.ok()) return found.status();
  const Functions& f = *found;

  std::vector<float> colour = interleaved(picture, [&](std::size_t c, int x, int y) {
    return 0.5f * (*picture.first[c].at(x, y) + *picture.second[c].at(x, y));
  });
  std::vector<float> albedo =
      interleaved(picture, [&](std::size_t c, int x, int y) { return *picture.guides[c].at(x, y); });
  std::vector<float> normal =
      interleaved(picture, [&](std::size_t c, int x, int y) { return *picture.guides[3 + c].at(x, y); });
  std::vector<float> output(colour.size());

  const std::unique_ptr<OidnDevice, void (*)(Device)> device(f.new_device(kDefaultDevice), f.release_device);
  f.commit_device(device.get());
  const std::unique_ptr<OidnFilter, void (*)(Filter)> filter(f.new_filter(device.get(), "RT"),
                                                             f.release_filter);
  const auto width = static_cast<std::size_t>(picture.width),
             height = static_cast<std::size_t>(picture.height);
  const auto set = [&](const char* name, std::vector<float>& pixels) {
    f.set_image(filter.get(), name, pixels.data(), kFloat3, width, height, 0, 0, 0);
  };
  set("color", colour), set("albedo", albedo), set("normal", normal), set("output", output);
  f.set_bool(filter.get(), "hdr", true);
  f.set_bool(filter.get(), "cleanAux", true);  // guides have been filtered
  f.commit_filter(filter.get());
  f.execute(filter.get());
  const char* message = nullptr;
  if (f.get_error(device.get(), &message) != 0)
    return absl::InternalError(absl::StrCat("Open Image Denoise: ", message != nullptr ? message : "failed"));

  Colours result;
  for (std::size_t i = 0; i < output.size(); ++i) result[i % 3].push_back(output[i]);
  return result;
}

}  // namespace tessera::client::denoise

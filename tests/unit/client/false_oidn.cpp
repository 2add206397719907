// A library with the C interface of Open Image Denoise, which denoises nothing: the output tells what it was
// given, half of the colour and a quarter of albedo and normal each.
#include <cstddef>
#include <cstring>
#include <map>
#include <string>

#define EXPORTED extern "C" [[gnu::visibility("default")]]

namespace {

struct Picture {
  float* pixels = nullptr;
  std::size_t width = 0, height = 0;
};

struct Device {
  const char* error = nullptr;
};

struct Filter {
  Device* device = nullptr;
  std::map<std::string, Picture> images;
  std::map<std::string, bool> flags;
  bool committed = false;
};

constexpr int kDefault = 0, kFloat3 = 3, kInvalid = 2;

}  // namespace

EXPORTED Device* oidnNewDevice(int type) { return type == kDefault ? new Device : nullptr; }
EXPORTED void oidnCommitDevice(Device*) {}
EXPORTED void oidnReleaseDevice(Device* device) { delete device; }
EXPORTED int oidnGetDeviceError(Device* device, const char** message) {
  *message = device->error;
  return device->error == nullptr ? 0 : kInvalid;
}
EXPORTED Filter* oidnNewFilter(Device* device, const char* type) {
  if (std::strcmp(type, "RT") != 0) device->error = "no such filter";
  return new Filter{device, {}, {}, false};
}
EXPORTED void oidnSetSharedFilterImage(Filter* filter, const char* name, void* pixels, int format,
                                       std::size_t width, std::size_t height, std::size_t offset,
                                       std::size_t pixel_stride, std::size_t row_stride) {
  if (format != kFloat3 || offset + pixel_stride + row_stride != 0) filter->device->error = "bad image";
  filter->images[name] = {static_cast<float*>(pixels), width, height};
}
EXPORTED void oidnSetFilterBool(Filter* filter, const char* name, bool value) { filter->flags[name] = value; }
EXPORTED void oidnCommitFilter(Filter* filter) { filter->committed = true; }
EXPORTED void oidnExecuteFilter(Filter* filter) {
  const Picture& colour = filter->images["color"];
  if (!filter->committed || !filter->flags["hdr"] || !filter->flags["cleanAux"] || colour.width == 7) {
    filter->device->error = "what it says";
    return;
  }
  for (std::size_t i = 0; i < 3 * colour.width * colour.height; ++i) {
    filter->images["output"].pixels[i] =
        0.5f * colour.pixels[i] +
        0.25f * (filter->images["albedo"].pixels[i] + filter->images["normal"].pixels[i]);
  }
}
EXPORTED void oidnReleaseFilter(Filter* filter) { delete filter; }

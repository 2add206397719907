// The module with OpenImageIO: the only file that includes it.
#include "images/module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <string>

namespace tessera::images {
namespace {

using Input = std::unique_ptr<OIIO::ImageInput>;

/// OpenImageIO's own reason where it gives one, which may repeat itself on further lines.
std::string reason_of(const OIIO::ImageInput& input, const char* otherwise) {
  std::string reason = input.geterror();
  return reason.empty() ? otherwise : reason.substr(0, reason.find('\n'));
}

/// The channels that are bands of a spectrum, "S0.550,000000nm" of light or "T.550,000000nm" of matter
/// [Fichet, Pacanowski & Wilkie 2021], of an image that has no colours beside them.
std::ptrdiff_t bands_alone(const OIIO::ImageSpec& spec) {
  const auto& names = spec.channelnames;
  if (std::ranges::find(names, "R") != names.end()) return 0;
  return std::ranges::count_if(names, [](const std::string& name) {
    return (name.starts_with("S") || name.starts_with("T.")) && name.ends_with("nm");
  });
}

/// A file in memory, opened. Null, with a message, when that fails.
Input open(OIIO::Filesystem::IOMemReader& memory, const char* format, OIIO::ImageSpec& spec,
           std::string& message) {
  Input input = OIIO::ImageInput::create(format);
  if (!input) {
    message = std::string("this build of OpenImageIO does not read ") + format;
    return nullptr;
  }
  if (!input->supports("ioproxy") || !input->set_ioproxy(&memory)) {
    message = std::string("this build of OpenImageIO does not read ") + format + " from memory";
    return nullptr;
  }
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (!input->open(std::string("image.") + format, spec, config)) {
    message = reason_of(*input, "its header is broken");
    return nullptr;
  }
  if (spec.deep) {
    message = "deep images are not supported";
  } else if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) {
    message = "it has no pixels";
  } else if (spec.depth > 1) {
    message = "volumes are not supported";
  } else if (const auto bands = bands_alone(spec); bands > 0) {
    message =
        "it has " + std::to_string(bands) +
        " bands of a spectrum, where red, green and blue were expected: tessera convert makes these of them";
  } else {
    return input;
  }
  return nullptr;
}

/// Reads all pixels into `values`, four channels each, `opaque` where there is no alpha.
template <class T>
bool read_pixels(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, T opaque,
                 T* values) {
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  // A picture without blue, as maps of places are, is no grey one.
  const bool red_and_green =
      spec.nchannels == 2 && spec.channelnames[0] == "R" && spec.channelnames[1] == "G";
  const bool grey = spec.nchannels < 3 && !red_and_green;
  const bool with_alpha = grey ? spec.nchannels == 2 && spec.alpha_channel == 1 : spec.nchannels > 3;
  const int channels = grey ? (with_alpha ? 2 : 1) : std::min(spec.nchannels, 4);
  if (!input.read_image(0, 0, 0, channels, type, values, 4 * sizeof(T))) return false;
  for (std::size_t i = 0; i < pixels; ++i) {
    T* const pixel = values + 4 * i;
    if (!with_alpha) pixel[3] = opaque;
    if (red_and_green) pixel[2] = 0;
    if (!grey) continue;
    if (with_alpha) pixel[3] = pixel[1];
    pixel[1] = pixel[2] = pixel[0];
  }
  return true;
}

ImageFault decode_file(std::string_view blob, const char* format, std::uint64_t max_pixels,
                       ImagePixels& pixels, std::string& message) {
  OIIO::Filesystem::IOMemReader memory(blob.data(), blob.size());
  OIIO::ImageSpec spec;
  const Input input = open(memory, format, spec, message);
  if (!input) return ImageFault::kInvalid;
  const std::uint64_t count =
      static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (count > max_pixels) {
    message = too_many_pixels({spec.width, spec.height}, max_pixels);
    return ImageFault::kTooLarge;
  }
  pixels.size = {spec.width, spec.height};
  pixels.floating_point = spec.format.is_floating_point();
  bool whole;
  if (spec.format == OIIO::TypeDesc::UINT8) {
    pixels.bytes.resize(count);
    whole = read_pixels<std::uint8_t>(*input, spec, OIIO::TypeDesc::UINT8, 255,
                                      reinterpret_cast<std::uint8_t*>(pixels.bytes.data()));
  } else {
    pixels.floats.resize(4 * count);
    whole = read_pixels<float>(*input, spec, OIIO::TypeDesc::FLOAT, 1, pixels.floats.data());
  }
  if (whole) return ImageFault::kNone;
  message = reason_of(*input, "it cannot be read to its end");
  return ImageFault::kInvalid;
}

ImageFault size_of_file(std::string_view blob, const char* format, ImageSize& size, std::string& message) {
  OIIO::Filesystem::IOMemReader memory(blob.data(), blob.size());
  OIIO::ImageSpec spec;
  if (!open(memory, format, spec, message)) return ImageFault::kInvalid;
  size = {spec.width, spec.height};
  return ImageFault::kNone;
}

/// OpenImageIO reports most faults by return value, but lets exceptions of the format libraries through.
template <class Work>
ImageFault guarded(std::string& message, const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    message = "there is not enough memory for it";
    return ImageFault::kTooLarge;
  } catch (const std::exception& error) {
    message = error.what();
    return ImageFault::kInvalid;
  }
}

constexpr ImageModule kModule = {
    [](std::string_view blob, const char* format, std::uint64_t max_pixels, ImagePixels& pixels,
       std::string& message) {
      return guarded(message, [&] { return decode_file(blob, format, max_pixels, pixels, message); });
    },
    [](std::string_view blob, const char* format, ImageSize& size, std::string& message) {
      return guarded(message, [&] { return size_of_file(blob, format, size, message); });
    }};

}  // namespace
}  // namespace tessera::images

extern "C" __attribute__((visibility("default"))) const tessera::images::ImageModule* tessera_images() {
  return &tessera::images::kModule;
}

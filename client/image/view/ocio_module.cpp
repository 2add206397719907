// The module with OpenColorIO (docs/colour.md).
#include "image/view/ocio_module.h"

#include <OpenColorIO/OpenColorIO.h>

#include <exception>

namespace tessera::client {
namespace {

namespace ocio = OCIO_NAMESPACE;

/// "Raw", "sRGB" of the names that a configuration lists by number.
template <class Name>
std::string names(int count, const Name& name) {
  std::string list;
  for (int i = 0; i < count; ++i) list += (i == 0 ? "\"" : ", \"") + std::string(name(i)) + "\"";
  return list;
}

bool has_view(const ocio::Config& config, const std::string& display, const std::string& view) {
  for (int i = 0; i < config.getNumViews(display.c_str()); ++i) {
    if (view == config.getView(display.c_str(), i)) return true;
  }
  return false;
}

/// Empty, or what the configuration lacks.
std::string lacking(const ocio::Config& config, const std::string& display, const std::string& view,
                    const std::string& space) {
  if (config.getNumViews(display.c_str()) == 0) {
    return "there is no display \"" + display + "\": it has " +
           names(config.getNumDisplays(), [&](int i) { return config.getDisplay(i); });
  }
  if (!has_view(config, display, view)) {
    return "display \"" + display + "\" has no view \"" + view + "\": it has " +
           names(config.getNumViews(display.c_str()),
                 [&](int i) { return config.getView(display.c_str(), i); });
  }
  if (config.getColorSpace(space.c_str()) == nullptr) {
    return "there is no space or role \"" + space + "\": it has " +
           names(config.getNumColorSpaces(), [&](int i) { return config.getColorSpaceNameByIndex(i); });
  }
  return {};
}

void* open(const std::string& path, const std::string& display, const std::string& view,
           const std::string& space, std::string& message) {
  try {
    const ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(path.c_str());
    config->validate();
    const std::string screen = display.empty() ? config->getDefaultDisplay() : display;
    const std::string shown = view.empty() ? config->getDefaultView(screen.c_str()) : view;
    message = lacking(*config, screen, shown, space);
    if (!message.empty()) return nullptr;
    const ocio::DisplayViewTransformRcPtr transform = ocio::DisplayViewTransform::Create();
    transform->setSrc(space.c_str());
    transform->setDisplay(screen.c_str());
    transform->setView(shown.c_str());
    return new ocio::ConstCPUProcessorRcPtr(config->getProcessor(transform)->getDefaultCPUProcessor());
  } catch (const std::exception& fault) {
    message = fault.what();
    return nullptr;
  }
}

void show(const void* processor, float* rgb, long pixels) {
  ocio::PackedImageDesc row(rgb, pixels, 1, 3);
  (*static_cast<const ocio::ConstCPUProcessorRcPtr*>(processor))->apply(row);
}

void close(void* processor) { delete static_cast<ocio::ConstCPUProcessorRcPtr*>(processor); }

}  // namespace
}  // namespace tessera::client

extern "C" __attribute__((visibility("default"))) const tessera::client::OcioModule* tessera_ocio() {
  static constexpr tessera::client::OcioModule kModule{tessera::client::open, tessera::client::show,
                                                       tessera::client::close};
  return &kModule;
}

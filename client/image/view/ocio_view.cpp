#include "image/view/ocio_view.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "base/installed_module.h"
#include "image/view/ocio_module.h"

namespace tessera::client {
namespace {

absl::StatusOr<const OcioModule*> open_module() {
  const auto entry =
      base::installed_module(kOcioModuleFile, kOcioModuleEntry, "OpenColorIO's views cannot be shown");
  if (!entry.ok()) return entry.status();
  return reinterpret_cast<OcioModuleEntry>(*entry)();
}

class OcioView final : public DisplayView {
 public:
  OcioView(const OcioModule& module, void* processor) : module_(module), processor_(processor) {}
  ~OcioView() override { module_.close(processor_); }
  OcioView(const OcioView&) = delete;
  OcioView& operator=(const OcioView&) = delete;

  void show(std::span<spectra::Triple> row) const override {
    std::vector<float> values;
    values.reserve(3 * row.size());
    for (const spectra::Triple& color : row) {
      for (const double value : color) values.push_back(static_cast<float>(value));
    }
    module_.show(processor_, values.data(), static_cast<long>(row.size()));
    for (std::size_t i = 0; i < values.size(); ++i) row[i / 3][i % 3] = values[i];
  }
  bool takes_rec709() const override { return false; }

 private:
  const OcioModule& module_;
  void* processor_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<DisplayView>> make_ocio_view(const ViewOptions& options) {
  static const absl::StatusOr<const OcioModule*> module = open_module();
  if (!module.ok()) return module.status();
  std::string message;
  void* const processor =
      (*module)->open(options.ocio_config, options.ocio_display, options.name, options.ocio_space, message);
  if (processor == nullptr)
    return absl::InvalidArgumentError(absl::StrCat(options.ocio_config, ": ", message));
  return std::make_unique<OcioView>(**module, processor);
}

}  // namespace tessera::client

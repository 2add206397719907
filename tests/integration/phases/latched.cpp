#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "integration/phases/latched_traits.h"
#include "render/kernel/kernel.h"
#include "render/renderer.h"

namespace tessera::render {
namespace {

struct Latch {
  int free_units;  // this many do not wait
  std::filesystem::path file;
};

std::optional<Latch> latch_of_this_process() {
  const char* const text = std::getenv(integration::kLatchVariable);
  if (text == nullptr) return std::nullopt;
  const std::string latch = text;
  const std::size_t colon = latch.find(':');
  return Latch{std::stoi(latch.substr(0, colon)), latch.substr(colon + 1)};
}

class Latched final : public Integrator {
 public:
  explicit Latched(const IntegratorContext& context)
      : path_(find_kernel(supported_isas().front())->find("path")->make(context)) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override {
    static const std::optional<Latch> latch = latch_of_this_process();
    static std::atomic<int> begun{0};
    if (latch && begun++ >= latch->free_units) {
      while (!std::filesystem::exists(latch->file)) {
        if (stop.stop_requested()) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
      }
    }
    return path_->render(work, film, stop);
  }

 private:
  const std::unique_ptr<Integrator> path_;
};

// Before main.
[[maybe_unused]] const bool added = [] {
  add_algorithm({.name = integration::kLatched,
                 .make = [](const IntegratorContext& context) -> std::unique_ptr<Integrator> {
                   return std::make_unique<Latched>(context);
                 }});
  return true;
}();

}  // namespace
}  // namespace tessera::render

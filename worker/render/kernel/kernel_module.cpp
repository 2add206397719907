#include "render/kernel/kernel_module.h"

#include <dlfcn.h>

#include <map>
#include <mutex>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/core/processor.h"

extern "C" {
extern const char tessera_kernel_build[];  // generated (kernel_build.cmake)
}

namespace tessera::render {
namespace {

/// Names the fault of a module that is open; empty where there is none.
std::string fault_of(void* module, const std::string& file) {
  const auto* const build = static_cast<const char*>(dlsym(module, kKernelBuildName));
  if (build != nullptr && std::string_view(build) == kernel_build()) return "";
  return absl::StrCat(file, " belongs to ", build == nullptr ? "a build without a name" : "build ",
                      build == nullptr ? "" : build, ", this program to build ", kernel_build(),
                      ": programs and kernel modules have to be installed together");
}

}  // namespace

const char* kernel_build() { return tessera_kernel_build; }

absl::StatusOr<const Kernel*> open_kernel_module(const std::string& file) {
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) {
    const char* const reason = dlerror();
    return absl::NotFoundError(reason == nullptr ? absl::StrCat(file, " cannot be opened") : reason);
  }
  if (const std::string fault = fault_of(module, file); !fault.empty()) {
    dlclose(module);
    return absl::FailedPreconditionError(fault);
  }
  // A module that is used is never closed: Embree holds pointers into it.
  const auto entry = reinterpret_cast<KernelEntry>(dlsym(module, kKernelEntryName));
  if (entry == nullptr) return absl::FailedPreconditionError(absl::StrCat(file, " is no kernel module"));
  return entry();
}

std::string kernel_file(const std::string& isa, KernelLight light) {
  return absl::StrCat(light == KernelLight::kRgb ? "libtessera_kernel_" : "libtessera_spectral_", isa, ".so");
}

absl::StatusOr<const Kernel*> kernel_of(const std::string& isa, KernelLight light) {
  static std::mutex mutex;
  static std::map<std::string, absl::StatusOr<const Kernel*>> opened;
  const std::string file = kernel_file(isa, light);
  const std::lock_guard lock(mutex);
  if (const auto it = opened.find(file); it != opened.end()) return it->second;
  absl::StatusOr<const Kernel*> kernel =
      processor_has(isa.c_str()) ? open_kernel_module(file)
                                 : absl::NotFoundError(absl::StrCat("this processor has no ", isa));
  return opened.emplace(file, std::move(kernel)).first->second;
}

}  // namespace tessera::render

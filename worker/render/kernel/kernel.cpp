#include "render/kernel/kernel.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include "render/accel/embree/accelerator.h"
#include "render/core/processor.h"
#include "render/renderer.h"
#include "wire/arithmetic_class.h"

namespace tessera::render {

namespace {

// From the best on.
constexpr const char* kIsas[] = {"avx512", "avx2", "neon"};

std::string module_of(const std::string& isa, KernelLight light = KernelLight::kRgb) {
  return (light == KernelLight::kRgb ? "libtessera_kernel_" : "libtessera_spectral_") + isa + ".so";
}

/// The folders in which dlopen() looks: the program's run path (deploy/cmake/TesseraOptions.cmake), which the
/// loader does not tell where it does not exist, then those of the system's configuration.
std::string search_path() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string own = (program.parent_path() / ".." / "lib").string();
  std::string path = own;
  void* const self = dlopen(nullptr, RTLD_LAZY);
  Dl_serinfo size{};
  if (self == nullptr || dlinfo(self, RTLD_DI_SERINFOSIZE, &size) != 0) return path;
  std::vector<std::max_align_t> buffer(size.dls_size / sizeof(std::max_align_t) + 1);
  auto* const folders = reinterpret_cast<Dl_serinfo*>(buffer.data());
  if (dlinfo(self, RTLD_DI_SERINFOSIZE, folders) != 0 || dlinfo(self, RTLD_DI_SERINFO, folders) != 0)
    return path;
  for (unsigned int i = 0; i < folders->dls_cnt; ++i) {
    const std::string folder = folders->dls_serpath[i].dls_name;
    if (folder != own) path += ", " + folder;
  }
  return path;
}

std::deque<Algorithm>& added_algorithms() {
  static std::deque<Algorithm> added;
  return added;
}

}  // namespace

void add_algorithm(const Algorithm& algorithm) { added_algorithms().push_back(algorithm); }

const Algorithm* Kernel::find(std::string_view name) const {
  const auto is_it = [&](const Algorithm& a) { return a.name == name; };
  if (const auto it = std::find_if(algorithms.begin(), algorithms.end(), is_it); it != algorithms.end())
    return &*it;
  const std::deque<Algorithm>& added = added_algorithms();
  const auto it = std::find_if(added.begin(), added.end(), is_it);
  return it == added.end() ? nullptr : &*it;
}

const Kernel* find_kernel(const std::string& isa, KernelLight light) {
  static std::mutex mutex;
  static std::map<std::string, const Kernel*> loaded;
  std::lock_guard lock(mutex);
  const std::string module_name = module_of(isa, light);
  if (auto it = loaded.find(module_name); it != loaded.end()) return it->second;
  const Kernel* kernel = nullptr;
  if (processor_has(isa)) {
    // Found by the program's run path. Never unloaded: Embree holds pointers into it.
    if (void* module = dlopen(module_name.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      if (auto entry = reinterpret_cast<KernelEntry>(dlsym(module, kKernelEntryName))) kernel = entry();
    }
  }
  return loaded[module_name] = kernel;
}

std::vector<std::string> supported_isas() {
  std::vector<std::string> isas;
  for (const char* isa : kIsas) {
    if (find_kernel(isa)) isas.emplace_back(isa);
  }
  return isas;
}

std::vector<std::string> arithmetic_classes(const std::vector<std::string>& isas) {
  std::vector<std::string> classes;
  for (const std::string& isa : isas) {
    const Kernel* const kernel = find_kernel(isa);
    classes.push_back(kernel == nullptr
                          ? isa
                          : wire::arithmetic_class(isa, embree_version(), kernel->arithmetic_checksum()));
  }
  return classes;
}

std::string why_no_kernels() {
  std::string modules, reasons;
  for (const char* isa : kIsas) {
    if (!processor_has(isa)) continue;
    const std::string module = module_of(isa);
    modules += (modules.empty() ? "" : ", ") + module;
    // A module that is there, and cannot be opened all the same, lacks a library.
    if (dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL) != nullptr) continue;
    if (const char* const error = dlerror(); error != nullptr) reasons += std::string("\n  ") + error;
  }
  if (modules.empty())
    return "this processor has neither AVX-512 nor AVX2 nor NEON, and there are kernels for no other";
  return "no kernels: one of " + modules +
         " is needed; they belong into the folder lib beside bin. Looked in " + search_path() + reasons;
}

RenderStats& RenderStats::operator+=(const RenderStats& other) {
  RenderCounts::operator+=(other);
  times += other.times;
  for (const std::string& warning : other.warnings) {
    if (warnings.size() < 8) warnings.push_back(warning);
  }
  return *this;
}

}  // namespace tessera::render

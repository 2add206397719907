#include "render/kernel/kernel.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "render/accel/embree/accelerator.h"
#include "render/core/processor.h"
#include "render/kernel/kernel_module.h"
#include "render/renderer.h"
#include "wire/arithmetic_class.h"

namespace tessera::render {

namespace {

// From the best on.
constexpr const char* kIsas[] = {"avx512", "avx2", "neon"};

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
  const absl::StatusOr<const Kernel*> kernel = kernel_of(isa, light);
  return kernel.ok() ? *kernel : nullptr;
}

std::vector<std::string> refused_kernels() {
  std::vector<std::string> faults;
  for (const char* isa : kIsas) {
    const absl::Status status = kernel_of(isa, KernelLight::kRgb).status();
    if (absl::IsFailedPrecondition(status)) faults.emplace_back(status.message());
  }
  return faults;
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
    const std::string module = kernel_file(isa, KernelLight::kRgb);
    modules += (modules.empty() ? "" : ", ") + module;
    // A module that is there may lack a library, or belong to another build.
    if (const absl::Status status = kernel_of(isa, KernelLight::kRgb).status(); !status.ok())
      reasons += "\n  " + std::string(status.message());
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

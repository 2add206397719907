#include "render/integrator/kernel.h"

#include <dlfcn.h>

#include <map>
#include <mutex>

#include "render/accel/accelerator.h"
#include "render/renderer.h"
#include "wire/arithmetic_class.h"

namespace tessera::render {

namespace {

bool processor_has(const std::string& isa) {
#if defined(__x86_64__)
  if (isa == "avx512") {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512cd");
  }
  if (isa == "avx2") {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  }
  return false;
#else
  return isa == "neon";
#endif
}

}  // namespace

const Kernel* find_kernel(const std::string& isa) {
  static std::mutex mutex;
  static std::map<std::string, const Kernel*> loaded;
  std::lock_guard lock(mutex);
  if (auto it = loaded.find(isa); it != loaded.end()) return it->second;
  const Kernel* kernel = nullptr;
  if (processor_has(isa)) {
    // Found by the program's run path. Never unloaded: Embree holds pointers into it.
    if (void* module = dlopen(("libtessera_kernel_" + isa + ".so").c_str(), RTLD_NOW | RTLD_LOCAL)) {
      if (auto entry = reinterpret_cast<KernelEntry>(dlsym(module, kKernelEntryName))) kernel = entry();
    }
  }
  return loaded[isa] = kernel;
}

std::vector<std::string> supported_isas() {
  std::vector<std::string> isas;
  for (const char* isa : {"avx512", "avx2", "neon"}) {
    if (find_kernel(isa)) isas.emplace_back(isa);
  }
  return isas;
}

std::vector<std::string> arithmetic_classes(const std::vector<std::string>& isas) {
  std::vector<std::string> classes;
  for (const std::string& isa : isas) {
    const Kernel* const kernel = find_kernel(isa);
    classes.push_back(kernel == nullptr ? isa
                                        : wire::arithmetic_class(isa, embree_version(), kernel->arithmetic_checksum()));
  }
  return classes;
}

RenderStats& RenderStats::operator+=(const RenderStats& other) {
  samples += other.samples;
  camera_rays += other.camera_rays;
  bounce_rays += other.bounce_rays;
  shadow_rays += other.shadow_rays;
  dropped_samples += other.dropped_samples;
  times += other.times;
  fireflies += other.fireflies;
  firefly_light += other.firefly_light;
  light += other.light;
  for (const std::string& warning : other.warnings) {
    if (warnings.size() < 8) warnings.push_back(warning);
  }
  return *this;
}

}  // namespace tessera::render

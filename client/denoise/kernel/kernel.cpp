#include "denoise/kernel/kernel.h"

#include <cstdlib>
#include <string_view>

#include "denoise_kernels.h"  // TESSERA_DENOISE_KERNELS: all that kernels are compiled for, the best first
#include "render/core/processor.h"

namespace tessera::client::denoise {

#define TESSERA_DENOISE_DECLARE(isa)                                                                       \
  namespace isa {                                                                                          \
  void statistical_row(const StatisticalTask&, int);                                                       \
  void patch_row(const PatchTask&, int, int, int, int, int, float*, float*);                               \
  void blend_row(const PlaneView*, int, const PlaneView&, int, int, int, int, const float*, float* const*, \
                 float*);                                                                                  \
  void fit_window(const FitTask&);                                                                         \
  }
TESSERA_DENOISE_KERNELS(TESSERA_DENOISE_DECLARE)

const Kernel& kernel() {
  static const Kernel best = [] {
#define TESSERA_DENOISE_TAKE(isa)                                      \
  if (std::string_view(#isa) == "base" || render::processor_has(#isa)) \
    return Kernel{isa::statistical_row, isa::patch_row, isa::fit_window, isa::blend_row};
    TESSERA_DENOISE_KERNELS(TESSERA_DENOISE_TAKE)
    std::abort();  // the last one is for every machine
  }();
  return best;
}

}  // namespace tessera::client::denoise

// Lens files of pbrt and Zemax, and what is made of them.
#include <cmath>

#include "fuzz/target.h"
#include "optics/lens_system.h"
#include "optics/pupil.h"
#include "optics/read/pbrt_lens_file.h"
#include "optics/read/zemax_file.h"

namespace tessera::fuzz {
namespace {

/// Whether there is a lens that casts an image. Kernels divide by the light in the middle of the film.
bool is_lens(const optics::Prescription& lens, std::vector<optics::Fault> faults) {
  if (faults.empty()) {
    if (const auto system = optics::LensSystem::focus(lens, {.focus = 2000}, faults)) {
      require(faults.empty(), "a lens with faults");
      const double light = optics::axial_irradiance(*system);
      require(std::isfinite(light) && light > 0, "a lens that lets no light through");
      require(std::isfinite(system->back_distance()) && system->back_distance() > 0,
              "a film within the lens");
      return true;
    }
  }
  require(!faults.empty(), "a lens is refused without a fault");
  for (const optics::Fault& fault : faults) require(!fault.message.empty(), "an error without a message");
  return false;
}

bool accepts_lens(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const std::string_view text(input.data(), input.size());
  std::vector<optics::Fault> pbrt_faults, zemax_faults;
  const optics::Prescription pbrt = optics::read_pbrt_lens(text, pbrt_faults);
  const optics::ZemaxLens zemax = optics::read_zemax_lens(text, zemax_faults);
  const bool is_pbrt = is_lens(pbrt, pbrt_faults);
  return is_lens(zemax.lens, zemax_faults) || is_pbrt;
}

}  // namespace

const Target kLens = {"lens", accepts_lens};

}  // namespace tessera::fuzz

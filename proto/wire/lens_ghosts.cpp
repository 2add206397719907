#include "wire/lens_ghosts.h"

#include "absl/strings/str_cat.h"
#include "wire/algorithm.h"

namespace tessera::wire {

absl::Status allows_light_into_lens(const v1::JobSpec& spec) {
  const v1::Algorithms& asked = spec.content().algorithms();
  const AlgorithmTraits* const algorithm = find_algorithm(asked.integrator());
  if (algorithm == nullptr || !algorithm->lens_ghosts) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", asked.integrator(),
                                                   "' sends no light into the lens: lens_ghosts 'lights' is "
                                                   "not for it"));
  }
  const auto cannot = [](const char* what) {
    return absl::InvalidArgumentError(absl::StrCat("lens_ghosts 'lights' does not go with ", what,
                                                   ": light lands anywhere on the picture, in passes"));
  };
  if (spec.samples().noise() != 0) return cannot("noise");
  if (spec.view().layers_size() > 0) return cannot("layers");
  if (spec.view().reconstruction() == v1::RECONSTRUCTION_SCATTER) return cannot("reconstruction 'scatter'");
  if (spec.view().path_sharing() > v1::PATH_SHARING_OFF) return cannot("path_sharing");
  if (asked.direct_light() == v1::DIRECT_LIGHT_BSDF) return cannot("direct_light 'bsdf'");
  return absl::OkStatus();
}

}  // namespace tessera::wire

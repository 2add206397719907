#include "wire/resolve_settings.h"

#include <algorithm>

#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/own_settings.h"

namespace tessera::wire {
namespace {

constexpr std::uint32_t kDefaultSpp = 16;
constexpr std::uint32_t kDefaultMaxDepth = 5;  // pbrt's

}  // namespace

void resolve_settings(const v1::RenderSettings& wishes, v1::JobSpec& job) {
  v1::Algorithms& algorithms = *job.mutable_content()->mutable_algorithms();
  algorithms.set_integrator(wishes.integrator().empty() ? wire::algorithms().front().name
                                                        : wishes.integrator());
  algorithms.set_intersection(or_default(wishes.intersection()));
  algorithms.set_direct_light(or_default(wishes.direct_light()));
  algorithms.set_light_selection(or_default(wishes.light_selection()));
  algorithms.set_traversal(or_default(wishes.traversal()));
  const v1::Accelerator accelerator = or_default(wishes.accelerator());
  algorithms.set_accelerator(accelerator == v1::ACCELERATOR_EMBREE ? v1::ACCELERATOR_UNSPECIFIED
                                                                   : accelerator);
  if (accelerator == v1::ACCELERATOR_GRID) algorithms.set_grid_density(wishes.grid_density());
  const v1::Nesting nesting = or_default(wishes.nesting());
  algorithms.set_nesting(nesting == v1::NESTING_AUTO ? v1::NESTING_UNSPECIFIED : nesting);
  if (wishes.glass_shadows() == v1::GLASS_SHADOWS_STRAIGHT)
    algorithms.set_glass_shadows(v1::GLASS_SHADOWS_STRAIGHT);
  algorithms.set_texture_filter(or_default(wishes.texture_filter()));
  resolve_own_settings(wishes, algorithms);
  v1::JobSpec::View& view = *job.mutable_view();
  view.set_sampler(or_default(wishes.sampler()));
  view.set_seed(wishes.seed());
  view.set_max_depth(std::min(wishes.has_max_depth() ? wishes.max_depth() : kDefaultMaxDepth, kMaxDepth));
  *view.mutable_layers() = wishes.layers();
  if (wishes.reconstruction() == v1::RECONSTRUCTION_SCATTER)
    view.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  if (wishes.path_sharing() > v1::PATH_SHARING_OFF) view.set_path_sharing(wishes.path_sharing());
  view.set_texture_footprint(wishes.has_texture_footprint() ? wishes.texture_footprint()
                                                            : kDefaultTextureFootprint);
  job.mutable_samples()->set_spp(wishes.spp() != 0 ? wishes.spp() : kDefaultSpp);
  view.set_sample_bits(sample_bits_of(job));
  job.mutable_samples()->set_noise(wishes.noise());
}

}  // namespace tessera::wire

#include "render/scene/view/settings.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>

#include "wire/aov_channels.h"
#include "wire/enum_words.h"
#include "wire/limits.h"
#include "wire/settings.h"

namespace tessera::render {

namespace {

std::optional<StructureKind> structure_of(v1::Accelerator asked) {
  std::optional<StructureKind> kind;
  for_each_structure([&, word = wire::word_of(asked)](const auto& row) {
    if (row.name == word) kind = row.kKind;
  });
  return kind;
}

OwnSettings own_settings(const v1::Algorithms& asked) {
  OwnSettings result;
  const wire::FieldType* const own = wire::own_settings(*asked.GetDescriptor(), asked.integrator());
  if (own == nullptr) return result;
  const google::protobuf::Message& message = asked.GetReflection()->GetMessage(asked, own);
  for (int i = 0; i < own->message_type()->field_count(); ++i) {
    const wire::FieldType& field = *own->message_type()->field(i);
    result.values.push_back({field.name(), wire::number_in(message, field)});
  }
  return result;
}

PhotonSettings photon_config(const v1::PhotonSettings& asked) {
  return {.radius = static_cast<float>(asked.radius()),
          .caustic_radius = static_cast<float>(asked.caustic_radius()),
          .photons = static_cast<std::uint32_t>(asked.photons()),
          .one_map = asked.map() == v1::PHOTON_MAP_CLASSIC,
          .direct = asked.light() == v1::PHOTON_LIGHT_ALL};
}

TexelFilter filter_of(v1::TextureFilter asked) {
  switch (asked) {
    case v1::TEXTURE_FILTER_TRILINEAR:
      return TexelFilter::kTrilinear;
    case v1::TEXTURE_FILTER_EWA:
      return TexelFilter::kEwa;
    default:
      return TexelFilter::kBilinear;
  }
}

}  // namespace

Settings read_settings(const v1::JobSpec& job) {
  const v1::Algorithms& asked = job.content().algorithms();
  Settings result;
  result.asked = asked;
  result.algorithm = wire::find_algorithm(asked.integrator());
  result.own = own_settings(asked);
  result.structure = structure_of(asked.accelerator());
  result.spectral = asked.color() == v1::COLOR_SPECTRAL;
  result.straight_shadows = asked.glass_shadows() == v1::GLASS_SHADOWS_STRAIGHT;
  result.light_into_lens = job.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS;
  result.texture_filter = filter_of(asked.texture_filter());
  if (asked.has_irradiance_cache()) {
    const v1::IrradianceCache& cache = asked.irradiance_cache();
    result.irradiance_cache = {.error = static_cast<float>(cache.error()),
                               .samples = static_cast<std::int32_t>(cache.samples()),
                               .least_reach = static_cast<float>(cache.least_reach()),
                               .most_reach = static_cast<float>(cache.most_reach()),
                               .view = cache.view(),
                               .glossy_bands = static_cast<std::int32_t>(cache.glossy_bands())};
  }
  const v1::RadiositySettings& radiosity = asked.radiosity();
  result.radiosity = {.error_bound = radiosity.error_bound(),
                      .smallest_area = radiosity.smallest_area(),
                      .residual = radiosity.residual(),
                      .final_gather = radiosity.final_gather(),
                      .memory_limit = radiosity.memory_limit()};
  result.ignore_non_diffuse = radiosity.ignore_non_diffuse();
  result.photon = photon_config(asked.photon());
  if (asked.has_mlt()) {
    const v1::MetropolisSettings& metropolis = asked.mlt();
    result.metropolis = {.mutations = metropolis.mutations(),
                         .candidates = metropolis.candidates(),
                         .large_steps = static_cast<float>(metropolis.large_steps()),
                         .step = static_cast<float>(metropolis.step())};
  }
  const v1::JobSpec::View& view = job.view();
  if (view.sampler() == v1::SAMPLER_INDEPENDENT) result.sampler.kind = SamplerKind::kIndependent;
  if (view.sampler() == v1::SAMPLER_Z_SOBOL) {
    result.sampler.kind = SamplerKind::kZSobol;
    result.sampler.sample_bits = static_cast<int>(view.sample_bits());
  }
  result.sampler.seed = view.seed();
  result.max_depth = static_cast<std::int32_t>(std::min(view.max_depth(), wire::kMaxDepth));
  for (const int aov : view.aovs()) {
    if (aov == v1::AOV_HALVES) result.aovs.halves = true;
    const wire::HitAovRow* const row = wire::find_hit_aov(static_cast<v1::AOV>(aov));
    if (row != nullptr) result.aovs.add(row->aov);
  }
  return result;
}

}  // namespace tessera::render

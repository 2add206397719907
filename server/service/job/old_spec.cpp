#include "service/job/old_spec.h"

#include <set>

#include "tessera/v1/old_job.pb.h"
#include "wire/enum_words.h"

namespace tessera::server {
namespace {

/// The value with this word; UNSPECIFIED, which is the default, for an empty one.
template <class Enum>
absl::Status read_word(const std::string& word, Enum& value) {
  if (word.empty()) return absl::OkStatus();
  const absl::StatusOr<Enum> known = wire::value_of<Enum>(word);
  if (known.ok()) value = *known;
  return known.status();
}

absl::Status convert_settings(const v1::OldJobSpec& old, v1::JobSpec& spec) {
  const v1::OldJobSpec::Settings& settings = old.settings();
  v1::Intersection intersection{};
  v1::DirectLight direct_light{};
  v1::LightSelection light_selection{};
  v1::Traversal traversal{};
  v1::Sampler sampler{};
  for (const absl::Status& status :
       {read_word(settings.intersection(), intersection), read_word(settings.direct_light(), direct_light),
        read_word(settings.light_selection(), light_selection), read_word(settings.traversal(), traversal),
        read_word(settings.sampler(), sampler)}) {
    if (!status.ok()) return status;
  }
  v1::Algorithms& algorithms = *spec.mutable_content()->mutable_algorithms();
  algorithms.set_integrator(settings.integrator());
  algorithms.set_intersection(intersection);
  algorithms.set_direct_light(direct_light);
  algorithms.set_light_selection(light_selection);
  algorithms.set_traversal(traversal);
  spec.mutable_view()->set_sampler(sampler);
  spec.mutable_view()->set_seed(settings.seed());
  spec.mutable_view()->set_max_depth(settings.max_depth());
  spec.mutable_samples()->set_spp(settings.spp());
  spec.mutable_samples()->set_noise(settings.noise());
  return absl::OkStatus();
}

absl::Status convert_aovs(const v1::OldJobSpec& old, v1::JobSpec& spec) {
  std::set<v1::AOV> aovs;  // ascending, each once
  for (const std::string& word : old.aovs()) {
    v1::AOV aov{};
    if (absl::Status status = read_word(word, aov); !status.ok()) return status;
    aovs.insert(aov);
  }
  for (const v1::AOV aov : aovs) spec.mutable_view()->add_aovs(aov);
  return absl::OkStatus();
}

absl::StatusOr<v1::JobSpec> convert(v1::OldJobSpec old) {
  v1::JobSpec spec;
  spec.mutable_content()->set_scene(old.scene().digest());
  spec.mutable_content()->set_build(old.build());
  if (auto s = convert_settings(old, spec); !s.ok()) return s;
  if (auto s = convert_aovs(old, spec); !s.ok()) return s;
  spec.mutable_view()->set_width(old.width());
  spec.mutable_view()->set_height(old.height());
  v1::JobSpec::Cut& cut = *spec.mutable_cut();
  *cut.mutable_crop() = old.crop();
  cut.set_tile_size(old.tile_size());
  cut.set_samples_per_unit(old.samples_per_unit());
  cut.mutable_phases()->Swap(old.mutable_phases());
  v1::JobSpec::Farm& farm = *spec.mutable_farm();
  farm.set_name(old.name());
  farm.set_user(old.user());
  farm.mutable_blobs()->Swap(old.mutable_blobs());
  *farm.add_blobs() = old.scene();
  farm.set_priority(old.priority());
  farm.mutable_required_tags()->Swap(old.mutable_required_tags());
  farm.set_max_workers(old.max_workers());
  farm.set_isa(old.isa());
  farm.set_bits(old.bits());
  return spec;
}

}  // namespace

absl::StatusOr<v1::JobSpec> read_spec(const std::string& bytes) {
  v1::JobSpec spec;
  v1::OldJobSpec old;
  if (spec.ParseFromString(bytes) && spec.has_content()) return spec;
  if (old.ParseFromString(bytes)) return convert(std::move(old));
  return absl::InvalidArgumentError("its spec cannot be read");
}

}  // namespace tessera::server

#include "service/job/old_spec.h"

#include <spdlog/spdlog.h>

#include <set>

#include "tessera/v1/old_job.pb.h"
#include "wire/enum_words.h"

namespace tessera::server {
namespace {

/// The value with this word; UNSPECIFIED, which is the default, for an empty one. Coordinators took words
/// that nobody knows, and workers failed such jobs, so that they are over; they must not keep a farm from
/// starting.
template <class Enum>
Enum read_word(const std::string& word) {
  if (word.empty()) return {};
  const absl::StatusOr<Enum> known = wire::value_of<Enum>(word);
  if (!known.ok())
    spdlog::warn("a job of an older version: {}; the default takes its place", known.status().ToString());
  return known.value_or(Enum{});
}

void convert_settings(const v1::OldJobSpec& old, v1::JobSpec& spec) {
  const v1::OldJobSpec::Settings& settings = old.settings();
  v1::Algorithms& algorithms = *spec.mutable_content()->mutable_algorithms();
  algorithms.set_integrator(settings.integrator());
  algorithms.set_intersection(read_word<v1::Intersection>(settings.intersection()));
  algorithms.set_direct_light(read_word<v1::DirectLight>(settings.direct_light()));
  algorithms.set_light_selection(read_word<v1::LightSelection>(settings.light_selection()));
  algorithms.set_traversal(read_word<v1::Traversal>(settings.traversal()));
  spec.mutable_view()->set_sampler(read_word<v1::Sampler>(settings.sampler()));
  spec.mutable_view()->set_seed(settings.seed());
  spec.mutable_view()->set_max_depth(settings.max_depth());
  spec.mutable_samples()->set_spp(settings.spp());
  spec.mutable_samples()->set_noise(settings.noise());
}

void convert_aovs(const v1::OldJobSpec& old, v1::JobSpec& spec) {
  std::set<v1::AOV> aovs;  // ascending, each once
  for (const std::string& word : old.aovs()) aovs.insert(read_word<v1::AOV>(word));
  aovs.erase(v1::AOV_UNSPECIFIED);
  for (const v1::AOV aov : aovs) spec.mutable_view()->add_aovs(aov);
}

v1::JobSpec convert(v1::OldJobSpec old) {
  v1::JobSpec spec;
  spec.mutable_content()->set_scene(old.scene().digest());
  spec.mutable_content()->set_build(old.build());
  convert_settings(old, spec);
  convert_aovs(old, spec);
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

/// Submissions are refused where they have such fields; jobs that were taken must not keep a farm from
/// starting.
void leave_out_unknown_fields(v1::JobSpec& spec) {
  if (const absl::Status known = wire::check_known(spec); !known.ok())
    spdlog::warn("a job of another version: {}; it is left out", std::string{known.message()});
  spec.DiscardUnknownFields();
}

}  // namespace

absl::StatusOr<v1::JobSpec> read_spec(const std::string& bytes) {
  v1::JobSpec spec;
  v1::OldJobSpec old;
  if (spec.ParseFromString(bytes) && spec.has_content()) {
    leave_out_unknown_fields(spec);
    return spec;
  }
  if (old.ParseFromString(bytes)) return convert(std::move(old));
  return absl::InvalidArgumentError("its spec cannot be read");
}

}  // namespace tessera::server

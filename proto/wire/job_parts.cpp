#include "wire/job_parts.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <array>
#include <string>

namespace tessera::wire {
namespace {

constexpr std::array kFields{
    JobField{"JobSpec", "scene", JobPart::kScene},
    JobField{"JobSpec", "width", JobPart::kView},
    JobField{"JobSpec", "height", JobPart::kView},
    JobField{"JobSpec", "aovs", JobPart::kView},
    JobField{"JobSpec", "crop", JobPart::kUnits},
    JobField{"JobSpec", "tile_size", JobPart::kUnits},
    JobField{"JobSpec", "samples_per_unit", JobPart::kUnits},
    JobField{"JobSpec", "phases", JobPart::kUnits},
    JobField{"JobSpec", "build", JobPart::kBuild},
    JobField{"JobSpec", "isa", JobPart::kKernels},
    JobField{"JobSpec", "name", JobPart::kFarm},
    JobField{"JobSpec", "blobs", JobPart::kFarm},  // the scene names them by digest
    JobField{"JobSpec", "priority", JobPart::kFarm},
    JobField{"JobSpec", "user", JobPart::kFarm},
    JobField{"JobSpec", "required_tags", JobPart::kFarm},
    JobField{"JobSpec", "max_workers", JobPart::kFarm},
    JobField{"JobSpec", "bits", JobPart::kFarm},
    JobField{"RenderSettings", "integrator", JobPart::kScene},
    JobField{"RenderSettings", "intersection", JobPart::kScene},
    JobField{"RenderSettings", "traversal", JobPart::kScene},
    JobField{"RenderSettings", "direct_light", JobPart::kScene},
    JobField{"RenderSettings", "light_selection", JobPart::kScene},
    JobField{"RenderSettings", "sampler", JobPart::kView},
    JobField{"RenderSettings", "seed", JobPart::kView},
    JobField{"RenderSettings", "max_depth", JobPart::kView},
    JobField{"RenderSettings", "noise", JobPart::kView},
    JobField{"RenderSettings", "spp", JobPart::kSamples},
};

void clear_others(google::protobuf::Message& message, std::span<const JobPart> parts) {
  const google::protobuf::Descriptor& type = *message.GetDescriptor();
  for (const JobField& field : kFields) {
    if (field.message != type.name() || std::find(parts.begin(), parts.end(), field.part) != parts.end())
      continue;
    message.GetReflection()->ClearField(&message, type.FindFieldByName(std::string{field.name}));
  }
}

}  // namespace

std::span<const JobField> job_fields() { return kFields; }

v1::JobSpec parts_of(const v1::JobSpec& spec, std::span<const JobPart> parts) {
  v1::JobSpec part = spec;
  clear_others(part, parts);
  clear_others(*part.mutable_settings(), parts);
  if (part.has_scene()) part.mutable_scene()->clear_path();  // its digest says all
  return part;
}

}  // namespace tessera::wire

#include "command/light_field/provenance.h"

#include "absl/strings/str_cat.h"
#include "google/protobuf/text_format.h"
#include "wire/version.h"

namespace tessera::client {

using google::protobuf::TextFormat;

light_field::Provenance provenance_of(const v1::JobSpec& spec, const RenderOptions& options) {
  light_field::Provenance provenance;
  provenance.program = absl::StrCat("tessera ", wire::build_version());
  provenance.scene = options.scene;
  provenance.scene_digest = spec.content().scene();
  provenance.integrator = spec.content().algorithms().integrator();
  provenance.seed = spec.view().seed();
  provenance.samples_per_pixel = spec.samples().spp();
  TextFormat::Printer printer;
  printer.SetSingleLineMode(true);
  printer.PrintToString(options.job.settings, &provenance.settings);
  provenance.defines = options.defines;
  return provenance;
}

absl::Status take_provenance(const light_field::Provenance& provenance, RenderOptions& options) {
  if (options.scene.empty()) options.scene = provenance.scene;
  options.defines = provenance.defines;
  if (TextFormat::ParseFromString(provenance.settings, &options.job.settings)) return absl::OkStatus();
  return absl::InvalidArgumentError("the settings in its provenance cannot be read");
}

}  // namespace tessera::client

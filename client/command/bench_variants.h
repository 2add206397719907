// The variants that `tessera bench --compare` measures.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "command/render_options.h"

namespace tessera::client {

/// An option with one of its values; neither where there is nothing to compare.
struct VariantOption {
  std::string option, value;

  std::string name() const { return option.empty() ? "" : option + "=" + value; }
};

/// Whether `compare` is "integrator=all" or "accelerator=all": all that can render the scene.
bool asks_for_all(const std::string& compare);

/// The variants of "OPTION=A,B"; one without an option for an empty text. InvalidArgument for any other.
absl::StatusOr<std::vector<VariantOption>> parse_compare(const std::string& compare);

/// The options with one more, as if the command line had ended in --OPTION VALUE.
absl::StatusOr<RenderOptions> with_option(RenderOptions options, const VariantOption& variant);

}  // namespace tessera::client

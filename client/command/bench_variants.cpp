#include "command/bench_variants.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"

namespace tessera::client {
namespace {

/// "integrator=all" and "accelerator=all" are comparisons of what can render the scene.
constexpr const char* kIntegrator = "integrator";
constexpr const char* kAccelerator = "accelerator";

/// All values of the option in `text` where it is "OPTION=all" of one of those; else none.
std::vector<VariantOption> all_values(const std::string& text) {
  std::vector<VariantOption> variants;
  if (text == absl::StrCat(kIntegrator, "=all")) {
    for (const wire::AlgorithmTraits& algorithm : wire::algorithms())
      variants.push_back({kIntegrator, algorithm.name});
  } else if (text == absl::StrCat(kAccelerator, "=all")) {
    for (const std::string& word : wire::words_of(*v1::Accelerator_descriptor()))
      variants.push_back({kAccelerator, word});
  }
  return variants;
}

}  // namespace

bool asks_for_all(const std::string& compare) { return !all_values(compare).empty(); }

absl::StatusOr<std::vector<VariantOption>> parse_compare(const std::string& text) {
  if (text.empty()) return std::vector<VariantOption>(1);
  const std::vector<std::string> sides = absl::StrSplit(text, absl::MaxSplits('=', 1));
  if (sides.size() != 2 || sides[0].empty())
    return absl::InvalidArgumentError("--compare: expected OPTION=A,B");
  std::vector<VariantOption> variants;
  if (variants = all_values(text); !variants.empty()) return variants;
  for (const std::string& value : std::vector<std::string>(absl::StrSplit(sides[1], ','))) {
    variants.push_back({sides[0], value});
  }
  if (variants.size() < 2)
    return absl::InvalidArgumentError("--compare: expected two values or more, OPTION=A,B");
  return variants;
}

absl::StatusOr<RenderOptions> with_option(RenderOptions options, const VariantOption& variant) {
  if (variant.option.empty()) return options;
  const absl::Status status =
      options::parse_options([&](options::Command& command) { define_job_options(command, options, false); },
                             {absl::StrCat("--", variant.option), variant.value});
  if (!status.ok())
    return absl::InvalidArgumentError(absl::StrCat("--compare ", variant.name(), ": ", status.message()));
  return options;
}

}  // namespace tessera::client
